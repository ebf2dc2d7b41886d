#include "core/quality/joint_coverage.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/arm/joint_units.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/formatted.hpp"
#include "core/math/units.hpp"

namespace truepose {
namespace {

constexpr double kNarrow = 0.25;  // of a joint's range
constexpr double kMiddle = 0.9;   // of the points, which say what part of it was used
constexpr double kOnStep = 1e-6;  // of a step: numbers that were written with so many decimals
constexpr double kRoundedLeast = 0.5, kRoundedMost = 2;  // times what rounding leaves

/// Part of its range that a joint was measured over.
double share_of_range(const Joint& joint, int i, std::span<const Measurement> points) {
  std::vector<double> q;
  for (const Measurement& point : points) q.push_back(point.q[i]);
  std::ranges::sort(q);
  const auto apart = static_cast<std::size_t>((1 - kMiddle) / 2 * static_cast<double>(q.size()));
  return (q[q.size() - 1 - apart] - q[apart]) / kMiddle / (joint.max - joint.min);
}

/// The step in degrees that all angles are multiples of, if it is one of a decimal; 0 where there is none.
double step_of(const RobotModel& robot, std::span<const Measurement> points) {
  for (const double step_deg : {1.0, 0.1, 0.01}) {
    const auto on_step = [&](const Measurement& point) {
      for (int i = 0; i < robot.joint_count(); ++i) {
        if (robot.joints[static_cast<std::size_t>(i)].type != JointType::Revolute) continue;
        const double steps = point.q[i] * kDegPerRad / step_deg;
        if (std::abs(steps - std::round(steps)) > kOnStep) return false;
      }
      return true;
    };
    if (std::ranges::all_of(points, on_step)) return step_deg;
  }
  return 0;
}

}  // namespace

std::optional<Finding> narrow_poses(const RobotModel& robot, std::span<const Measurement> points) {
  if (points.empty()) return std::nullopt;
  std::string narrow;
  int count = 0;
  for (int i = 0; i < robot.joint_count(); ++i) {
    const double share = share_of_range(robot.joints[static_cast<std::size_t>(i)], i, points);
    if (!(share < kNarrow)) continue;
    narrow += formatted("%s%d (%.0f %%)", count > 0 ? ", " : "", i + 1, 100 * share);
    ++count;
  }
  if (2 * count <= robot.joint_count()) return std::nullopt;
  return finding(FindingKind::NarrowPoses,
                 "the poses take up less than a quarter of the range of most joints: " + narrow +
                     "; elsewhere the model was not seen");
}

std::optional<Finding> rounded_joints(const CalibratedCell& cell, std::span<const Measurement> points) {
  const double step_deg = step_of(cell.robot, points);
  if (points.empty() || step_deg <= 0) return std::nullopt;
  Eigen::VectorXd left;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, left, J);
  const ParameterLayout layout = ParameterLayout::of(cell);
  double squares = 0;
  for (int i = 0; i < layout.joints; ++i)
    if (cell.robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute)
      squares += J.col(zero_parameter(cell.robot, layout, i)).squaredNorm();
  const auto coordinates = static_cast<double>(left.size());
  const double rounding_mm = step_deg * kRadPerDeg / std::sqrt(12.0) * std::sqrt(squares / coordinates);
  const double left_mm = left.norm() / std::sqrt(coordinates);
  if (left_mm < kRoundedLeast * rounding_mm || left_mm > kRoundedMost * rounding_mm) return std::nullopt;
  return finding(
      step_deg > 0.05 ? FindingKind::CoarseJoints : FindingKind::RoundedJoints,
      formatted("all joints are given to %g deg, which alone leaves %.2f mm in each coordinate, and "
                "%.2f mm are left",
                step_deg, rounding_mm, left_mm));
}

}  // namespace truepose
