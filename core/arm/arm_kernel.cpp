#include "core/arm/arm_kernel.hpp"

#include <Eigen/Core>
#include <cassert>
#include <cmath>

#include "core/arm/guide.hpp"
#include "core/arm/joint_coupling.hpp"

namespace truepose {

static_assert(kernels::kMostJoints == kMaxJoints);
static_assert(kMaxJoints + kMostGuides * kMotionsOfGuide <= kernels::kMostLinks);

namespace {

/// As link_transform() at q = 0, without taking the sines again.
void transform(const kernels::Link& link, double* T) {
  const double ca = link.cos_alpha, sa = link.sin_alpha, cb = link.cos_beta, sb = link.sin_beta;
  const double ct = link.cos_theta, st = link.sin_theta;
  Eigen::Map<Eigen::Matrix4d>(T) << cb * ct + sb * sa * st, sb * sa * ct - cb * st, sb * ca,
      cb * link.a_mm + sb * ca * link.d_mm,                                                           //
      ca * st, ca * ct, -sa, -sa * link.d_mm,                                                         //
      cb * sa * st - sb * ct, sb * st + cb * sa * ct, cb * ca, cb * ca * link.d_mm - sb * link.a_mm,  //
      0, 0, 0, 1;
}

void add_link(const Joint& joint, kernels::Arm& arm) {
  const int i = arm.joints++;
  arm.link[i] = {.cos_beta = std::cos(joint.beta_rad),
                 .sin_beta = std::sin(joint.beta_rad),
                 .cos_alpha = std::cos(joint.alpha_rad),
                 .sin_alpha = std::sin(joint.alpha_rad),
                 .a_mm = joint.a_mm,
                 .theta_rad = joint.theta_rad,
                 .cos_theta = std::cos(joint.theta_rad),
                 .sin_theta = std::sin(joint.theta_rad),
                 .d_mm = joint.d_mm};
  transform(arm.link[i], arm.transform[i]);
  (joint.type == JointType::Revolute ? arm.turn : arm.slide)[i] = joint.sign;
}

void add_flange(const Eigen::Isometry3d& X_flange, kernels::Arm& arm) {
  Eigen::Map<Eigen::Matrix4d>(arm.transform[arm.joints]) = X_flange.matrix();
  arm.bare = X_flange.matrix().isIdentity(0);
}

}  // namespace

kernels::Arm folded(const RobotModel& robot) {
  kernels::Arm arm{};
  for (const Joint& joint : robot.joints) add_link(joint, arm);
  add_flange(robot.X_flange, arm);
  return arm;
}

kernels::Arm folded_with_guides(const RobotModel& robot) {
  const auto guided = guided_joints(robot);
  kernels::Arm arm{};
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    add_link(robot.joints[i], arm);
    if (!guided[i]) continue;
    for (const GuideMotion& motion : kGuideMotions) add_link(link_of_motion(motion), arm);
  }
  add_flange(robot.X_flange, arm);
  return arm;
}

ArmKernel::ArmKernel(const RobotModel& robot, const kernels::Kernels& code)
    : arm_{folded(robot)}, coupling_{robot.coupling}, code_{&code} {
  assert(1 <= arm_.joints && arm_.joints <= kMaxJoints);
}

/// Most arms have no coupled joints, and copying them takes half as long as the kernel itself.
template <typename Use>
void ArmKernel::with_chain_joints(const JointVector& q, Use use) const {
  assert(q.size() == joint_count());
  if (coupling_.empty()) return use(q.data());
  use(chain_joints(coupling_, q).data());
}

Eigen::Isometry3d ArmKernel::forward(const JointVector& q) const {
  Eigen::Isometry3d X_BF;
  with_chain_joints(q, [&](const double* chain) { code_->forward(arm_, chain, X_BF.data()); });
  return X_BF;
}

void ArmKernel::forward(const Eigen::Ref<const Eigen::ArrayXXd>& q, Eigen::Ref<PoseColumns> X_BF) const {
  assert(q.cols() == joint_count() && X_BF.rows() == q.rows());
  if (!coupling_.empty()) {
    Eigen::ArrayXXd chain = q;
    for (const JointCoupling& each : coupling_) chain.col(each.joint) += each.factor * q.col(each.to);
    code_->forward_batch(arm_, chain.data(), chain.outerStride(), X_BF.data(), X_BF.outerStride(),
                         static_cast<int>(q.rows()));
    return;
  }
  code_->forward_batch(arm_, q.data(), q.outerStride(), X_BF.data(), X_BF.outerStride(),
                       static_cast<int>(q.rows()));
}

void ArmKernel::forward_with_jacobian(const JointVector& q, PoseAndJacobian& out) const {
  out.J.resize(6, joint_count());
  with_chain_joints(
      q, [&](const double* chain) { code_->forward_jacobian(arm_, chain, out.X_BF.data(), out.J.data()); });
  to_controller_columns(coupling_, out.J);
}

std::expected<PoseInverseResult, PoseInverseFault> ArmKernel::inverse_near(
    const Eigen::Isometry3d& X_BF, const JointVector& q_seed, const PoseInverseOptions& options) const {
  assert(q_seed.size() == joint_count());
  PoseInverseResult result{.q = chain_joints(coupling_, q_seed)};
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
      if (options.in_parts) break;
      return std::unexpected(PoseInverseFault::DidNotConverge);
    case kernels::InverseStatus::NotFinite:
      return std::unexpected(PoseInverseFault::NotFinite);
  }
  result.q = controller_joints(coupling_, result.q);
  result.residual_mm = outcome.residual_mm;
  result.residual_rad = outcome.residual_rad;
  result.iterations = outcome.iterations;
  return result;
}

}  // namespace truepose
