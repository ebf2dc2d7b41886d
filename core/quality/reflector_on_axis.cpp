#include "core/quality/reflector_on_axis.hpp"

#include <algorithm>
#include <cmath>

#include "core/fit/measurement_model.hpp"
#include "core/fit/null_space.hpp"
#include "core/formatted.hpp"

namespace truepose {
namespace {

/// So many usual deviations of the last link's angles have to show.
constexpr double kToShow = 5;

}  // namespace

std::optional<Finding> reflectors_on_last_axis(const CalibratedCell& cell,
                                               std::span<const Measurement> points, double sigma_mm) {
  const RobotModel& robot = cell.robot;
  if (points.empty() || robot.joints.back().type != JointType::Revolute) return std::nullopt;
  Eigen::VectorXd left;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, left, J);
  const ParameterLayout layout = ParameterLayout::of(cell);
  const int zero = zero_parameter(robot, layout, layout.joints - 1);
  double lever_mm = 0;
  for (Eigen::Index row = 0; row < left.size(); row += 3)
    lever_mm = std::max(lever_mm, J.col(zero).segment<3>(row).norm());
  const double least_rad = kToShow * usual_deviation(layout)[zero];
  const double seen_mm = sigma_mm / std::sqrt(static_cast<double>(points.size()));
  if (lever_mm * least_rad > seen_mm) return std::nullopt;
  return finding(
      FindingKind::ReflectorOnAxis,
      formatted("%s on the axis of joint %d (%.2f mm off it), so its points show nothing of what is "
                "behind that joint",
                cell.reflectors.size() == 1 ? "the reflector is" : "all reflectors are", layout.joints,
                lever_mm));
}

}  // namespace truepose
