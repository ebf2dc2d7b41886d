#include "core/calibration/calibrate.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/calibration/gauss_newton.hpp"
#include "core/calibration/identifiability.hpp"
#include "core/calibration/linear_start.hpp"
#include "core/calibration/measurement_model.hpp"
#include "core/calibration/parameters.hpp"
#include "core/kinematics/angles.hpp"

namespace truepose {
namespace {

constexpr int kFewestPoses = 5;

std::vector<Measurement> points_of(const MeasurementData& data, PoseSet set) {
  std::vector<Measurement> points;
  std::ranges::copy_if(data.points, std::back_inserter(points),
                       [set](const Measurement& m) { return m.set == set; });
  return points;
}

int count_poses(std::span<const Measurement> points) {
  int poses = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto earlier = points.first(i);
    poses += std::ranges::none_of(earlier, [&](const Measurement& m) { return m.q == points[i].q; });
  }
  return poses;
}

std::optional<CalibrationError> unusable(const RobotModel& arm, std::span<const std::string> smr_names,
                                         std::span<const Measurement> points) {
  for (const Measurement& point : points) {
    if (point.q.size() == arm.joint_count() && point.q.allFinite() && point.p_WS_mm.allFinite()) continue;
    return CalibrationError{CalibrationFault::NotFinite,
                            "row " + std::to_string(point.row) + " holds a number that is not finite"};
  }
  for (std::size_t k = 0; k < smr_names.size(); ++k) {
    if (std::ranges::any_of(points,
                            [k](const Measurement& m) { return static_cast<std::size_t>(m.smr) == k; }))
      continue;
    return CalibrationError{CalibrationFault::TooFewPoses,
                            "reflector '" + smr_names[k] + "' has no point to identify it from"};
  }
  const int poses = count_poses(points);
  if (poses >= kFewestPoses) return std::nullopt;
  return CalibrationError{CalibrationFault::TooFewPoses,
                          std::to_string(poses) + " poses to identify from; base and reflector alone need " +
                              std::to_string(kFewestPoses)};
}

/// 1 / sigma relative to the smallest sigma, where every point states one; else empty.
Eigen::VectorXd weights_of(std::span<const Measurement> points) {
  if (!std::ranges::all_of(points, [](const Measurement& m) { return m.sigma_mm.has_value(); })) return {};
  const double finest =
      *std::ranges::min_element(points, {}, [](const Measurement& m) { return *m.sigma_mm; })->sigma_mm;
  Eigen::VectorXd weights(static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i)
    weights[static_cast<Eigen::Index>(i)] = finest / *points[i].sigma_mm;
  return weights;
}

std::vector<int> first_parameters(int count) {
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

/// The coarse stage on points already found usable.
std::expected<GaussNewtonResult, CalibrationError> fit_base_and_reflectors(
    const RobotModel& arm, std::span<const std::string> smr_names, std::span<const Measurement> points,
    const Eigen::VectorXd& weights, int max_iterations) {
  const CalibratedCell start = linear_start(arm, smr_names, points);
  const std::vector<int> free = first_parameters(ParameterLayout::of(start).link(0));
  const GaussNewtonResult fit =
      gauss_newton(start, points, free, weights, {.max_iterations = max_iterations});

  const Eigen::MatrixXd J = linearise(fit.cell, points, free, weights).J;
  const Identifiability known = identifiability(J, Eigen::VectorXd::Ones(J.cols()));
  if (known.rank < static_cast<int>(free.size())) {
    const auto names = parameter_names(fit.cell);
    std::string lost;
    for (const int k : free) {
      if (!std::ranges::binary_search(known.kept, k))
        lost += (lost.empty() ? "" : ", ") + names[static_cast<std::size_t>(k)];
    }
    return std::unexpected(CalibrationError{
        CalibrationFault::NotSeparable,
        "base and reflector offset cannot be told apart (" + lost +
            " follow from the others): measure poses whose flange orientations differ about all axes"});
  }
  return fit;
}

struct FineFit {
  GaussNewtonResult fit;
  Identifiability known;
  std::vector<int> free;
};

FineFit fit_all(const CalibratedCell& coarse, std::span<const Measurement> points,
                const Eigen::VectorXd& weights, const CalibrateOptions& options) {
  const ParameterLayout layout = ParameterLayout::of(coarse);
  const std::vector<int> all = first_parameters(layout.size());
  FineFit fine;
  fine.known = identifiability(linearise(coarse, points, all, weights).J, conventional_preference(layout));
  fine.free = options.method == CalibrationMethod::TwoStage ? fine.known.kept : all;
  fine.fit =
      gauss_newton(coarse, points, fine.free, weights, {.max_iterations = options.max_fine_iterations});
  return fine;
}

/// Covariance of the free parameters: sigma0^2 (J'J)^-1, by the pseudo-inverse at unit column norm.
Eigen::MatrixXd covariance(const Eigen::MatrixXd& J, double sigma0) {
  const Eigen::VectorXd inverse_norm = column_norms(J).cwiseInverse();
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(J * inverse_norm.asDiagonal(), Eigen::ComputeThinV);
  const Eigen::VectorXd& s = svd.singularValues();
  const Eigen::VectorXd variance =
      s.unaryExpr([&](double v) { return v > kRankTolerance * s[0] ? sigma0 * sigma0 / (v * v) : 0.0; });
  const Eigen::MatrixXd scaled = inverse_norm.asDiagonal() * svd.matrixV();
  return scaled * variance.asDiagonal() * scaled.transpose();
}

std::vector<IdentifiedParameter> described(const CalibratedCell& nominal, const CalibratedCell& fitted,
                                           const std::vector<int>& free,
                                           const Eigen::MatrixXd& free_covariance) {
  const ParameterLayout layout = ParameterLayout::of(fitted);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  for (std::size_t i = 0; i < free.size(); ++i) {
    for (std::size_t j = 0; j < free.size(); ++j) {
      all(free[i], free[j]) = free_covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    }
  }
  // The fit turns the base about the tracker's axes; what is printed are its Euler angles.
  const Eigen::Matrix3d rates = angle_rates_zyx(fitted.base.rxyz_rad).inverse();
  all.block<3, 3>(3, 3) = (rates * all.block<3, 3>(3, 3) * rates.transpose()).eval();

  const auto names = parameter_names(fitted);
  const Eigen::VectorXd before = parameter_values(nominal), after = parameter_values(fitted);
  std::vector<IdentifiedParameter> parameters;
  for (int k = 0; k < layout.size(); ++k) {
    const bool is_link = k >= layout.link(0);
    parameters.push_back({.name = names[static_cast<std::size_t>(k)],
                          .nominal = is_link ? before[k] : 0.0,
                          .value = after[k],
                          .sigma = std::sqrt(all(k, k)),
                          .identified = std::ranges::binary_search(free, k)});
  }
  return parameters;
}

StageErrors stage_errors(const Calibration& calibration, const MeasurementData& data, PoseSet set) {
  std::vector<Eigen::Vector3d> before, geometric, after;
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    if (data.points[i].set != set) continue;
    before.push_back(calibration.points[i].before);
    geometric.push_back(calibration.points[i].geometric);
    after.push_back(calibration.points[i].after);
  }
  return {.poses = count_poses(points_of(data, set)),
          .points = static_cast<int>(before.size()),
          .before = error_statistics(before),
          .geometric = error_statistics(geometric),
          .after = error_statistics(after)};
}

}  // namespace

std::expected<CalibratedCell, CalibrationError> coarse_fit(const RobotModel& arm,
                                                           const MeasurementData& data) {
  if (auto error = unusable(arm, data.smr_names, data.points)) return std::unexpected(*error);
  auto fit = fit_base_and_reflectors(arm, data.smr_names, data.points, weights_of(data.points), 200);
  if (!fit) return std::unexpected(fit.error());
  return fit->cell;
}

std::expected<Calibration, CalibrationError> calibrate(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options) {
  const std::vector<Measurement> points = points_of(data, PoseSet::Identify);
  if (auto error = unusable(nominal, data.smr_names, points)) return std::unexpected(*error);
  const Eigen::VectorXd weights = weights_of(points);

  auto coarse =
      fit_base_and_reflectors(nominal, data.smr_names, points, weights, options.max_coarse_iterations);
  if (!coarse) return std::unexpected(coarse.error());
  FineFit fine = fit_all(coarse->cell, points, weights, options);
  const int equations = 3 * static_cast<int>(points.size());
  if (equations <= fine.known.rank) {
    return std::unexpected(CalibrationError{
        CalibrationFault::TooFewPoses, std::to_string(points.size()) + " points give " +
                                           std::to_string(equations) +
                                           " equations for at least as many parameters: measure more poses"});
  }

  const LinearSystem end = linearise(fine.fit.cell, points, fine.free, weights);
  Calibration result{.method = options.method,
                     .converged = coarse->converged && fine.fit.converged,
                     .coarse_iterations = coarse->iterations,
                     .fine_iterations = fine.fit.iterations,
                     .coarse = coarse->cell,
                     .cell = fine.fit.cell,
                     .rank = fine.known.rank,
                     .rank_gap = fine.known.gap,
                     .condition = fine.known.condition,
                     .sigma0_mm = std::sqrt(end.f.squaredNorm() / (equations - fine.known.rank))};
  result.parameters = described(result.coarse, result.cell, fine.free, covariance(end.J, result.sigma0_mm));

  for (const Measurement& point : data.points) {
    const Eigen::Vector3d geometric = result.cell.predict(point.q, point.smr) - point.p_WS_mm;
    result.points.push_back(
        {result.coarse.predict(point.q, point.smr) - point.p_WS_mm, geometric, geometric});
  }
  result.identify = stage_errors(result, data, PoseSet::Identify);
  if (points.size() < data.points.size()) result.validate = stage_errors(result, data, PoseSet::Validate);
  return result;
}

}  // namespace truepose
