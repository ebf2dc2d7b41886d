#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/kinematics/joint_deviation.hpp"
#include "core/kinematics/robot_model.hpp"

namespace truepose {

/// Pose X_WB of the robot base in the tracker frame: R = Rz(rz) Ry(ry) Rx(rx). mm, rad.
struct BasePose {
  Eigen::Vector3d p_mm{0, 0, 0};
  Eigen::Vector3d rxyz_rad{0, 0, 0};  ///< (rx, ry, rz)

  Eigen::Isometry3d isometry() const;
  static BasePose of(const Eigen::Isometry3d& X_WB);
};

struct Reflector {
  std::string name;
  Eigen::Vector3d p_FS_mm{0, 0, 0};  ///< centre of the reflector in the flange frame
};

/// A robot as the tracker sees it: the arm, where it stands, and the reflectors on its flange.
struct CalibratedCell {
  RobotModel robot;
  BasePose base;
  std::vector<Reflector> reflectors;

  /// Where the tracker should see reflector `smr` with the encoders at `q`: p_WS, mm.
  Eigen::Vector3d predict(const JointVector& q, int smr, Approach approach = {}) const;
};

}  // namespace truepose
