#include "core/arm/pose_inverse.hpp"

#include "core/arm/arm_kernel.hpp"
#include "core/arm/robot_model.hpp"
#include "core/math/angles.hpp"

namespace truepose {
namespace {

constexpr int kMaxCorrections = 20;

/// An arm that deviates beyond its geometry stands at X_BF where its geometry stands a little elsewhere: the
/// inverse of the geometry, its target and its joints corrected by what the deviation is there. Each
/// correction is a thousand times smaller than the one before.
std::expected<PoseInverseResult, PoseInverseFault> deviating_inverse_near(const RobotModel& robot,
                                                                          const ArmKernel& geometry,
                                                                          const Eigen::Isometry3d& X_BF,
                                                                          const JointVector& q_seed,
                                                                          const PoseInverseOptions& options) {
  PoseInverseResult result{.q = q_seed};
  PoseInverseOptions left = options;
  for (int i = 0; i < kMaxCorrections; ++i) {
    const JointVector joints = true_joints(robot, result.q, options.approach);
    const Eigen::Isometry3d X_geometry = geometry.forward(joints);
    const Eigen::Isometry3d X_now = displaced(robot, result.q, joints, X_geometry);
    result.residual_mm = (X_now.translation() - X_BF.translation()).norm();
    result.residual_rad = angle_between(X_now.linear(), X_BF.linear());
    if (result.residual_mm <= options.position_tolerance_mm &&
        result.residual_rad <= options.rotation_tolerance_rad) {
      return result;
    }
    if (options.in_parts) left.max_iterations = options.max_iterations - result.iterations;
    if (left.max_iterations <= 0) return result;
    const auto solved = geometry.inverse_near(X_geometry * inverse_of(X_now) * X_BF, joints, left);
    if (!solved) return std::unexpected(solved.error());
    result.q += solved->q - joints;
    result.iterations += solved->iterations;
  }
  return std::unexpected(PoseInverseFault::DidNotConverge);
}

}  // namespace

std::expected<PoseInverseResult, PoseInverseFault> inverse_near(const RobotModel& robot,
                                                                const Eigen::Isometry3d& X_BF,
                                                                const JointVector& q_seed,
                                                                const PoseInverseOptions& options) {
  return inverse_near(robot, ArmKernel{robot}, X_BF, q_seed, options);
}

std::expected<PoseInverseResult, PoseInverseFault> inverse_near(const RobotModel& robot,
                                                                const ArmKernel& geometry,
                                                                const Eigen::Isometry3d& X_BF,
                                                                const JointVector& q_seed,
                                                                const PoseInverseOptions& options) {
  if (robot.deviation.empty() && !robot.field) return geometry.inverse_near(X_BF, q_seed, options);
  return deviating_inverse_near(robot, geometry, X_BF, q_seed, options);
}

}  // namespace truepose
