#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/arm/pose_inverse.hpp"
#include "core/kernels/kernels.hpp"

namespace truepose {

/// Poses of many joint positions, one row each: x, y and z axis of the flange and its origin (mm), in the
/// base frame; column-major, so that a column is one coordinate of all poses.
using PoseColumns = Eigen::Array<double, Eigen::Dynamic, 12>;

/// The arm's geometry in the kernels' form, which takes the joints of the chain (chain_joints()).
/// @param robot  1 to kMaxJoints joints
kernels::Arm folded(const RobotModel& robot);
/// The same with the motions of guides as links, see link_of_motion(). Neither allocates.
kernels::Arm folded_with_guides(const RobotModel& robot);

/// An arm prepared for being evaluated often: the constants of every link folded once, vector code of this
/// machine. Says the same as forward_kinematics(), forward_with_jacobian() and a Newton on them, many times
/// faster. Holds the arm's geometry as it was at construction. Does not allocate.
class ArmKernel {
 public:
  /// @param robot  1 to kMaxJoints joints
  explicit ArmKernel(const RobotModel& robot, const kernels::Kernels& code = kernels::best());

  int joint_count() const { return arm_.joints; }

  /// Pose X_BF of the flange in the base frame, mm.
  Eigen::Isometry3d forward(const JointVector& q) const;

  /// The poses of many joint positions.
  ///
  /// @param q       one row per pose, one column per joint (rad, mm)
  /// @param X_BF    as many rows as q
  void forward(const Eigen::Ref<const Eigen::ArrayXXd>& q, Eigen::Ref<PoseColumns> X_BF) const;

  /// Pose and geometric Jacobian, as forward_with_jacobian().
  void forward_with_jacobian(const JointVector& q, PoseAndJacobian& out) const;

  /// Joint positions at which the arm stands at X_BF, as truepose::inverse_near().
  std::expected<PoseInverseResult, PoseInverseFault> inverse_near(
      const Eigen::Isometry3d& X_BF, const JointVector& q_seed, const PoseInverseOptions& options = {}) const;

 private:
  template <typename Use>
  void with_chain_joints(const JointVector& q, Use use) const;

  kernels::Arm arm_;
  std::vector<JointCoupling> coupling_;
  const kernels::Kernels* code_;
};

}  // namespace truepose
