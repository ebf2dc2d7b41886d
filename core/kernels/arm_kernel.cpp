#include "core/kernels/arm_kernel.hpp"

#include <Eigen/Core>
#include <cassert>

namespace truepose {

static_assert(kernels::kMostJoints == kMaxJoints);

kernels::Arm folded(const RobotModel& robot) {
  kernels::Arm arm{};
  arm.joints = robot.joint_count();
  for (int i = 0; i < arm.joints; ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    Eigen::Map<Eigen::Matrix4d>(arm.link[i]) = link_transform(joint, 0).matrix();
    (joint.type == JointType::Revolute ? arm.turn : arm.slide)[i] = joint.sign;
  }
  Eigen::Map<Eigen::Matrix4d>(arm.link[arm.joints]) = robot.X_flange.matrix();
  return arm;
}

ArmKernel::ArmKernel(const RobotModel& robot, const kernels::Kernels& code)
    : arm_{folded(robot)}, code_{&code} {
  assert(1 <= arm_.joints && arm_.joints <= kMaxJoints);
}

Eigen::Isometry3d ArmKernel::forward(const JointVector& q) const {
  assert(q.size() == joint_count());
  Eigen::Isometry3d X_BF;
  code_->forward(arm_, q.data(), X_BF.data());
  return X_BF;
}

void ArmKernel::forward(const Eigen::Ref<const Eigen::ArrayXXd>& q, Eigen::Ref<PoseColumns> X_BF) const {
  assert(q.cols() == joint_count() && X_BF.rows() == q.rows());
  code_->forward_batch(arm_, q.data(), q.outerStride(), X_BF.data(), X_BF.outerStride(),
                       static_cast<int>(q.rows()));
}

void ArmKernel::forward_with_jacobian(const JointVector& q, PoseAndJacobian& out) const {
  assert(q.size() == joint_count());
  out.J.resize(6, joint_count());
  code_->forward_jacobian(arm_, q.data(), out.X_BF.data(), out.J.data());
}

std::expected<PoseInverseResult, PoseInverseFault> ArmKernel::inverse_near(
    const Eigen::Isometry3d& X_BF, const JointVector& q_seed, const PoseInverseOptions& options) const {
  assert(q_seed.size() == joint_count());
  PoseInverseResult result{.q = q_seed};
  const kernels::InverseOutcome outcome =
      code_->inverse(arm_, X_BF.data(),
                     {.position_tolerance_mm = options.position_tolerance_mm,
                      .rotation_tolerance_rad = options.rotation_tolerance_rad,
                      .length_mm = options.length_mm,
                      .max_iterations = options.max_iterations,
                      .leaps = options.leaps},
                     result.q.data());
  switch (outcome.status) {
    case kernels::InverseStatus::Converged:
      break;
    case kernels::InverseStatus::DidNotConverge:
      return std::unexpected(PoseInverseFault::DidNotConverge);
    case kernels::InverseStatus::NotFinite:
      return std::unexpected(PoseInverseFault::NotFinite);
  }
  result.residual_mm = outcome.residual_mm;
  result.residual_rad = outcome.residual_rad;
  result.iterations = outcome.iterations;
  return result;
}

}  // namespace truepose
