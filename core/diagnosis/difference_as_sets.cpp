#include "core/diagnosis/difference_as_sets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/fit/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr std::size_t kDescents =
    16;  // from the best of 53 starts; with 8 the right arm is missed now and then
constexpr int kMostSteps = 20;
constexpr double kStillFalls = 0.98;  // of the difference before the step
constexpr double kFarOff = 5;         // times the median: the ends of both sets, where outliers stand
constexpr double kHold = 1e-3;        // of a reflector that the distances do not show

/// The rows' points as a linear function of where the reflectors are at the flange, about their own mean.
struct AboutTheirMean {
  Eigen::Matrix3Xd origin_mm;    ///< with all reflectors at the flange's centre, a column for each row
  Eigen::MatrixXd by_reflector;  ///< three rows for each row, three columns for each reflector

  AboutTheirMean(const RobotModel& arm, Eigen::Index reflectors, std::span<const Measurement> rows);
};

AboutTheirMean::AboutTheirMean(const RobotModel& arm, Eigen::Index reflectors,
                               std::span<const Measurement> rows) {
  const std::vector<Eigen::Isometry3d> flange = flange_poses(arm, rows);
  const auto count = static_cast<Eigen::Index>(rows.size());
  origin_mm.resize(3, count);
  by_reflector = Eigen::MatrixXd::Zero(3 * count, 3 * reflectors);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(3, 3 * reflectors);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Isometry3d& X_BF = flange[static_cast<std::size_t>(k)];
    const Eigen::Index column = 3 * rows[static_cast<std::size_t>(k)].smr;
    origin_mm.col(k) = X_BF.translation();
    by_reflector.block<3, 3>(3 * k, column) = X_BF.linear();
    mean.middleCols<3>(column) += X_BF.linear() / static_cast<double>(count);
  }
  origin_mm.colwise() -= origin_mm.rowwise().mean().eval();
  for (Eigen::Index k = 0; k < count; ++k) by_reflector.middleRows<3>(3 * k) -= mean;
}

/// Distances of the measured points from their mean, sorted.
std::vector<double> sorted_distances(std::span<const Measurement> rows) {
  Eigen::Vector3d mean{0, 0, 0};
  for (const Measurement& row : rows) mean += row.p_WS_mm / static_cast<double>(rows.size());
  std::vector<double> distances;
  for (const Measurement& row : rows) distances.push_back((row.p_WS_mm - mean).norm());
  std::ranges::sort(distances);
  return distances;
}

/// The rows' points with the reflectors somewhere, each with the measured distance of its own rank.
struct Comparison {
  Eigen::Matrix3Xd p_mm;      ///< about their mean
  Eigen::VectorXd length_mm;  ///< of its columns
  Eigen::VectorXd off_mm;     ///< what each measured distance is longer
  double median_mm = 0;       ///< of the size of off_mm
};

Comparison compared(const AboutTheirMean& reached, const std::vector<double>& measured_mm,
                    const Eigen::VectorXd& t) {
  Comparison result{.p_mm = reached.origin_mm, .length_mm = {}, .off_mm = {}};
  result.p_mm.reshaped() += reached.by_reflector * t;
  result.length_mm = result.p_mm.colwise().norm();
  std::vector<Eigen::Index> ranked(measured_mm.size());
  std::iota(ranked.begin(), ranked.end(), 0);
  std::ranges::sort(ranked, {}, [&](Eigen::Index k) { return result.length_mm[k]; });
  result.off_mm.resize(result.length_mm.size());
  for (std::size_t rank = 0; rank < ranked.size(); ++rank)
    result.off_mm[ranked[rank]] = measured_mm[rank] - result.length_mm[ranked[rank]];
  const Eigen::VectorXd size = result.off_mm.cwiseAbs();
  result.median_mm = median({size.begin(), size.end()});
  return result;
}

/// Gauss-Newton's step of the reflectors, by the rows that are not far off.
Eigen::VectorXd step_of(const Comparison& at, const AboutTheirMean& reached) {
  Eigen::MatrixXd slope = Eigen::MatrixXd::Zero(at.off_mm.size(), reached.by_reflector.cols());
  for (Eigen::Index k = 0; k < at.off_mm.size(); ++k) {
    if (std::abs(at.off_mm[k]) > kFarOff * at.median_mm || !(at.length_mm[k] > 0)) continue;
    slope.row(k) = at.p_mm.col(k).transpose() / at.length_mm[k] * reached.by_reflector.middleRows<3>(3 * k);
  }
  Eigen::MatrixXd A = transposed_times(slope, slope);
  A.diagonal().array() += kHold;
  return solve_symmetric(A, transposed_times(slope, at.off_mm)).col(0);
}

/// The least difference on the way down from `t`.
double descended(const AboutTheirMean& reached, const std::vector<double>& measured_mm, Eigen::VectorXd t) {
  double least_mm = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kMostSteps; ++step) {
    const Comparison at = compared(reached, measured_mm, t);
    if (!(at.median_mm < kStillFalls * least_mm)) break;
    least_mm = at.median_mm;
    t += step_of(at, reached);
  }
  return least_mm;
}

/// The reflectors, all at the same place of the flange: a grid around its centre.
std::vector<Eigen::VectorXd> starts(Eigen::Index reflectors) {
  std::vector<Eigen::VectorXd> starts{Eigen::VectorXd::Zero(3 * reflectors)};
  for (const double step_mm : {150, 300}) {
    for (int k = 0; k < 27; ++k) {
      const Eigen::Vector3d place(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (!place.isZero()) starts.push_back((step_mm * place).replicate(reflectors, 1));
    }
  }
  return starts;
}

}  // namespace

double difference_as_sets(const RobotModel& arm, std::size_t reflectors, std::span<const Measurement> rows) {
  const AboutTheirMean reached(arm, static_cast<Eigen::Index>(reflectors), rows);
  const std::vector<double> measured_mm = sorted_distances(rows);
  std::vector<std::pair<double, Eigen::VectorXd>> from;
  for (const Eigen::VectorXd& t : starts(static_cast<Eigen::Index>(reflectors)))
    from.emplace_back(compared(reached, measured_mm, t).median_mm, t);
  std::ranges::sort(from, {}, &std::pair<double, Eigen::VectorXd>::first);
  from.resize(kDescents);
  double least_mm = std::numeric_limits<double>::infinity();
  for (const auto& [start_mm, t] : from) least_mm = std::min(least_mm, descended(reached, measured_mm, t));
  return least_mm;
}

}  // namespace truepose
