#pragma once

#include "core/kernels/arm_kernel.hpp"
#include "core/kinematics/joint_deviation.hpp"

namespace truepose {

/// forward_kinematics() of one arm at many joint positions: deviations and field included, the links by the
/// kernels. Keeps a reference to the arm, which does not change meanwhile.
class FlangePoses {
 public:
  explicit FlangePoses(const RobotModel& robot) : robot_{robot}, kernel_{robot} {}

  /// X_BF, mm.
  Eigen::Isometry3d at(const JointVector& q, Approach approach = {}) const;

 private:
  const RobotModel& robot_;
  ArmKernel kernel_;
};

}  // namespace truepose
