#include "core/calibration/calibrated_cell.hpp"

#include "core/kinematics/angles.hpp"
#include "core/kinematics/forward.hpp"

namespace truepose {

Eigen::Isometry3d BasePose::isometry() const {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.linear() = rotation_zyx(rxyz_rad.z(), rxyz_rad.y(), rxyz_rad.x());
  X_WB.translation() = p_mm;
  return X_WB;
}

BasePose BasePose::of(const Eigen::Isometry3d& X_WB) {
  return {X_WB.translation(), angles_zyx(X_WB.linear())};
}

Eigen::Vector3d CalibratedCell::predict(const JointVector& q, int smr, Approach approach) const {
  const Eigen::Isometry3d X_BF = forward_kinematics(robot, q, approach);
  return base.isometry() * (X_BF * reflectors[static_cast<std::size_t>(smr)].p_FS_mm);
}

}  // namespace truepose
