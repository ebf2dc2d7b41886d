#include "core/fit/target_turns.hpp"

#include <algorithm>
#include <cmath>

#include "core/arm/forward.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/statistics.hpp"
#include "core/math/units.hpp"

namespace truepose {
namespace {

/// The rotation nearest to a sum of rotations.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& sum) {
  const Svd svd = thin_svd(sum);
  Eigen::Matrix3d U = svd.U, V = svd.V;
  if (U.determinant() * V.determinant() < 0) V.col(2) *= -1;
  return U * V.transpose();
}

Eigen::Matrix3d flange_turn(const CalibratedCell& cell, const RobotModel& loaded, const Measurement& point) {
  return cell.base_at(point.station).isometry().linear() *
         forward_kinematics(loaded, point.q, point.direction).linear();
}

/// About the flange's axes, from the reading to the prediction.
Eigen::Vector3d turn_of(const Eigen::Matrix3d& R_WF, const Eigen::Matrix3d& R_FT, const Measurement& point) {
  return turn_between(Eigen::Matrix3d::Identity(), R_FT * point.orientation->R_WT.transpose() * R_WF);
}

double weight_of(const Measurement& point, std::span<const double> weight, std::size_t i) {
  return weight.empty() ? 1 / point.orientation->sigma_rad : weight[i];
}

std::size_t reflector_of(const Measurement& point) { return static_cast<std::size_t>(point.smr); }

/// Weighted means of what the readings of each reflector say.
template <typename Value>
struct Means {
  std::vector<Value> sum;
  std::vector<double> weight;

  Means(std::size_t reflectors, const Value& zero) : sum(reflectors, zero), weight(reflectors, 0.0) {}
  void add(std::size_t reflector, double w, const Value& value) {
    sum[reflector] += w * value;
    weight[reflector] += w;
  }
  Value of(std::size_t reflector) const {
    return weight[reflector] > 0 ? Value(sum[reflector] / weight[reflector]) : sum[reflector];
  }
};

/// The turns of the oriented points and their derivative to every parameter, less the mean of their
/// reflector's.
struct CentredTurns {
  std::vector<std::size_t> points;
  Means<Eigen::Vector3d> mean_turn;
  Means<PointJacobian> mean_J;
  std::vector<Eigen::Vector3d> turn;
  std::vector<PointJacobian> J;

  CentredTurns(const CalibratedCell& cell, std::span<const Measurement> measured,
               std::span<const double> weight)
      : points{oriented_points(measured)},
        mean_turn{cell.reflectors.size(), Eigen::Vector3d::Zero()},
        mean_J{cell.reflectors.size(), PointJacobian::Zero(3, ParameterLayout::of(cell).size())} {
    const auto R_FT = best_mountings(cell, measured, weight);
    CalibratedCell loaded = cell;
    LoadedArm arm(cell.robot);
    for (const std::size_t i : points) {
      const Measurement& point = measured[i];
      loaded.robot.payload = arm.at(point).payload;
      PointJacobian& of_point = J.emplace_back();
      const Eigen::Matrix3d R_WF =
          turn_with_jacobian(loaded, point.q, of_point, point.direction, point.station);
      turn.push_back(turn_of(R_WF, R_FT[reflector_of(point)].value_or(Eigen::Matrix3d::Identity()), point));
      // Of a turn that is not small the derivative is another, but the gradient is not: what is left out is
      // across the turn. So what turns the flange and its target alike, as joint 6 does, has a column of
      // zeros.
      of_point = (R_WF.transpose() * of_point).eval();
      const double w = std::pow(weight_of(point, weight, i), 2);
      mean_turn.add(reflector_of(point), w, turn.back());
      mean_J.add(reflector_of(point), w, of_point);
    }
    for (std::size_t n = 0; n < points.size(); ++n) {
      const std::size_t reflector = reflector_of(measured[points[n]]);
      turn[n] -= mean_turn.of(reflector);
      J[n] -= mean_J.of(reflector);
    }
  }
};

}  // namespace

std::vector<std::size_t> oriented_points(std::span<const Measurement> points) {
  std::vector<std::size_t> oriented;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (points[i].orientation) oriented.push_back(i);
  return oriented;
}

std::vector<double> turn_weights(std::span<const Measurement> points, double finest_mm) {
  std::vector<double> weights(points.size(), 0.0);
  const std::vector<std::size_t> oriented = oriented_points(points);
  for (const std::size_t i : oriented) weights[i] = finest_mm / points[i].orientation->sigma_rad;
  return oriented.empty() ? std::vector<double>{} : weights;
}

std::vector<std::optional<Eigen::Matrix3d>> best_mountings(const CalibratedCell& cell,
                                                           std::span<const Measurement> points,
                                                           std::span<const double> weight) {
  Means<Eigen::Matrix3d> mean(cell.reflectors.size(), Eigen::Matrix3d::Zero());
  LoadedArm arm(cell.robot);
  for (const std::size_t i : oriented_points(points)) {
    const Measurement& point = points[i];
    mean.add(reflector_of(point), std::pow(weight_of(point, weight, i), 2),
             flange_turn(cell, arm.at(point), point).transpose() * point.orientation->R_WT);
  }
  std::vector<std::optional<Eigen::Matrix3d>> best(cell.reflectors.size());
  for (std::size_t k = 0; k < best.size(); ++k)
    if (mean.weight[k] > 0) best[k] = nearest_rotation(mean.sum[k]);
  return best;
}

std::vector<Eigen::Vector3d> target_turns(const CalibratedCell& cell, std::span<const Measurement> points,
                                          std::span<const std::optional<Eigen::Matrix3d>> R_FT) {
  std::vector<Eigen::Vector3d> turns(points.size(), Eigen::Vector3d::Zero());
  LoadedArm arm(cell.robot);
  for (const std::size_t i : oriented_points(points)) {
    const Eigen::Matrix3d R_WF = flange_turn(cell, arm.at(points[i]), points[i]);
    turns[i] = turn_of(R_WF, R_FT[reflector_of(points[i])].value_or(Eigen::Matrix3d::Identity()), points[i]);
  }
  return turns;
}

std::vector<double> whitened_turns(const CalibratedCell& cell, std::span<const Measurement> points,
                                   std::span<const double> weight, std::span<const double> trust) {
  std::vector<double> lengths(points.size(), 0.0);
  if (weight.empty()) return lengths;
  std::vector<double> trusted(weight.begin(), weight.end());
  for (std::size_t i = 0; i < trust.size(); ++i) trusted[i] *= std::sqrt(trust[i]);
  const std::vector<Eigen::Vector3d> turns =
      target_turns(cell, points, best_mountings(cell, points, trusted));
  for (std::size_t i = 0; i < lengths.size(); ++i) lengths[i] = weight[i] * turns[i].norm();
  return lengths;
}

std::vector<double> turn_sigmas(const CalibratedCell& cell, std::span<const Measurement> points,
                                std::span<const std::optional<Eigen::Matrix3d>> R_FT,
                                const Eigen::MatrixXd& covariance, double factor) {
  std::vector<double> sigmas(points.size(), 0.0);
  CalibratedCell loaded = cell;
  LoadedArm arm(cell.robot);
  PointJacobian J;
  for (const std::size_t i : oriented_points(points)) {
    const Measurement& point = points[i];
    loaded.robot.payload = arm.at(point).payload;
    const Eigen::Matrix3d R_WF = turn_with_jacobian(loaded, point.q, J, point.direction, point.station);
    const Eigen::Matrix3d S =
        std::pow(factor * point.orientation->sigma_rad, 2) * Eigen::Matrix3d::Identity() +
        congruence(R_WF.transpose() * J, covariance);
    const auto& mounted = R_FT[reflector_of(point)];
    if (mounted) sigmas[i] = (inverse_cholesky(S) * turn_of(R_WF, *mounted, point)).norm();
  }
  return sigmas;
}

std::string reason_not_an_arm(std::span<const double> turn_rad) {
  constexpr double kMost_rad = 0.05;
  if (turn_rad.empty()) return {};
  const double half_rad = median({turn_rad.begin(), turn_rad.end()});
  if (half_rad < kMost_rad) return {};
  return formatted(
      "the targets' orientations do not follow the arm: half of them are off by more than %.1f deg "
      "(limit %.1f); give the target's axes in the tracker's frame",
      half_rad * kDegPerRad, kMost_rad * kDegPerRad);
}

void append_turns(LinearSystem& system, const CalibratedCell& cell, const LeastSquaresProblem& problem) {
  if (problem.turn_weight.empty()) return;
  const CentredTurns turns(cell, problem.points, problem.turn_weight);
  Eigen::Index row = system.f.size();
  const Eigen::Index rows = row + 3 * static_cast<Eigen::Index>(turns.points.size());
  system.f.conservativeResize(rows);
  system.J.conservativeResize(rows, Eigen::NoChange);
  for (std::size_t n = 0; n < turns.points.size(); ++n, row += 3) {
    const double weight = problem.turn_weight[turns.points[n]];
    system.f.segment<3>(row) = weight * turns.turn[n];
    system.J.middleRows<3>(row) = weight * turns.J[n](Eigen::all, problem.free);
  }
  system.mountings =
      3 * static_cast<int>(std::ranges::count_if(turns.mean_turn.weight, [](double w) { return w > 0; }));
}

std::vector<std::optional<Mounting>> mountings(const CalibratedCell& cell,
                                               std::span<const Measurement> points,
                                               const Eigen::MatrixXd& covariance, double scale) {
  const auto best = best_mountings(cell, points);
  std::vector<std::optional<Mounting>> found(best.size());
  if (std::ranges::none_of(best, [](const auto& R_FT) { return R_FT.has_value(); })) return found;
  const CentredTurns turns(cell, points, {});
  for (std::size_t k = 0; k < best.size(); ++k) {
    if (!best[k]) continue;
    const double by_readings = 3 * scale * scale / turns.mean_turn.weight[k];
    const double by_arm = congruence(turns.mean_J.of(k), covariance).trace();
    found[k] = Mounting{*best[k], std::sqrt((by_readings + by_arm) / 3)};
  }
  return found;
}

}  // namespace truepose
