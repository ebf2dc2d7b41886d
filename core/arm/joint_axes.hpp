#pragma once

#include <Eigen/Geometry>
#include <span>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// A joint as a line in space: where its axis stands in the base frame with all joints at 0.
struct JointAxis {
  Joint joint;                           ///< type, limits, speed and acceleration are taken
  Eigen::Vector3d point_B_mm{0, 0, 0};   ///< on the axis
  Eigen::Vector3d direction_B{0, 0, 1};  ///< unit length; q counts about or along it
};

/// An arm by the lines of its joints.
struct ArmOfAxes {
  RobotModel robot;
  /// Where the arm's base frame stands in the frame of the lines: identity, or shifted to the first axis
  /// where no row of five parameters reaches that axis from the old origin.
  Eigen::Isometry3d X_base = Eigen::Isometry3d::Identity();
};

/// The modified DH rows (with Hayati's beta for axes that are parallel within 3 deg) and the flange with
/// the forward kinematics of the lines, to rounding. Signs are chosen for lengths d of at least 0 and
/// theta within +-90 deg, which are the rows of data sheets.
///
/// @param axes   1..kMaxJoints joints, base to flange
/// @param X_BF   the flange with all joints at 0
/// Source: Craig's modified DH by common normals; Hayati 1983 for parallel axes.
ArmOfAxes arm_of_axes(std::span<const JointAxis> axes, const Eigen::Isometry3d& X_BF);

}  // namespace truepose
