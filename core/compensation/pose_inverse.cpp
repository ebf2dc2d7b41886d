#include "core/compensation/pose_inverse.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/kinematics/forward.hpp"

namespace truepose {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Rotation vector (rad) of R, well conditioned near zero, where Newton ends.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::Vector3d twice_sin(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double sin_angle = 0.5 * twice_sin.norm();
  const double cos_angle = 0.5 * (R.trace() - 1);
  if (cos_angle > 0 && sin_angle < 1e-6) return 0.5 * twice_sin;
  const Eigen::AngleAxisd angle_axis(R);
  return angle_axis.angle() * angle_axis.axis();
}

/// Pose error from `actual` to `target`: mm, rad, base frame.
Vector6d pose_error(const Eigen::Isometry3d& target, const Eigen::Isometry3d& actual) {
  Vector6d e;
  e << target.translation() - actual.translation(),
      rotation_vector(target.linear() * actual.linear().transpose());
  return e;
}

}  // namespace

std::expected<PoseInverseResult, PoseInverseFault> inverse_near(const RobotModel& robot,
                                                                const Eigen::Isometry3d& X_BF,
                                                                const JointVector& q_seed,
                                                                const PoseInverseOptions& options) {
  Vector6d weight;
  weight << 1, 1, 1, options.length_mm, options.length_mm, options.length_mm;
  // A step of 1 rad costs as much as one of length_mm of a prismatic joint.
  JointVector unit(robot.joint_count());
  for (Eigen::Index i = 0; i < unit.size(); ++i) {
    unit[i] = robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute ? 1.0 : options.length_mm;
  }

  PoseInverseResult result;
  result.q = q_seed;
  PoseAndJacobian at = forward_with_jacobian(robot, result.q);
  Vector6d error = pose_error(X_BF, at.X_BF);
  double cost = (weight.asDiagonal() * error).squaredNorm();
  double damping = 0;
  for (;; ++result.iterations) {
    if (!std::isfinite(cost)) return std::unexpected(PoseInverseFault::NotFinite);
    result.residual_mm = error.head<3>().norm();
    result.residual_rad = error.tail<3>().norm();
    if (result.residual_mm <= options.position_tolerance_mm &&
        result.residual_rad <= options.rotation_tolerance_rad) {
      return result;
    }
    if (result.iterations == options.max_iterations) return std::unexpected(PoseInverseFault::DidNotConverge);

    const JointJacobian J = weight.asDiagonal() * at.J * unit.asDiagonal();
    Matrix6d normal = J * J.transpose();
    const double scale = normal.trace() / 6;
    // The floor keeps the factorisation finite in an exact singularity and is below rounding elsewhere.
    normal.diagonal().array() += scale * std::max(damping, 1e-15);
    const Vector6d multiplier = normal.ldlt().solve(Vector6d(weight.asDiagonal() * error));
    const JointVector q_next = result.q + unit.asDiagonal() * (J.transpose() * multiplier);

    const PoseAndJacobian next = forward_with_jacobian(robot, q_next);
    const Vector6d next_error = pose_error(X_BF, next.X_BF);
    const double next_cost = (weight.asDiagonal() * next_error).squaredNorm();
    if (next_cost < cost || next_cost <= options.position_tolerance_mm * options.position_tolerance_mm) {
      result.q = q_next;
      at = next;
      error = next_error;
      cost = next_cost;
      damping = damping < 1e-9 ? 0 : damping / 10;
    } else if (!std::isfinite(next_cost)) {
      return std::unexpected(PoseInverseFault::NotFinite);
    } else {
      damping = std::max(1e-6, damping * 10);
    }
  }
}

std::expected<PoseInverseResult, PoseInverseFault> compensate_joints(const RobotModel& nominal,
                                                                     const RobotModel& calibrated,
                                                                     const JointVector& q,
                                                                     const PoseInverseOptions& options) {
  return inverse_near(calibrated, forward_kinematics(nominal, q), q, options);
}

}  // namespace truepose
