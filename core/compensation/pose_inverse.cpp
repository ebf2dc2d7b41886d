#include "core/compensation/pose_inverse.hpp"

#include "core/kernels/arm_kernel.hpp"

namespace truepose {

std::expected<PoseInverseResult, PoseInverseFault> inverse_near(const RobotModel& robot,
                                                                const Eigen::Isometry3d& X_BF,
                                                                const JointVector& q_seed,
                                                                const PoseInverseOptions& options) {
  return ArmKernel{robot}.inverse_near(X_BF, q_seed, options);
}

std::expected<PoseInverseResult, PoseInverseFault> compensate_joints(const RobotModel& nominal,
                                                                     const RobotModel& calibrated,
                                                                     const JointVector& q,
                                                                     const PoseInverseOptions& options) {
  return inverse_near(calibrated, forward_kinematics(nominal, q), q, options);
}

}  // namespace truepose
