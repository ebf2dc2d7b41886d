#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// Joint positions of an arm, and where its controller by its own reckoning has the flange there.
struct ControllerPose {
  JointVector q;
  Eigen::Isometry3d X_BF;
};

/// Largest distance that the flange's origin and a point 100 mm along each of its axes are apart in two
/// poses, mm.
double flange_deviation_mm(const Eigen::Isometry3d& A, const Eigen::Isometry3d& B);

/// How far the controller and the nominal arm at most are apart, mm; NaN where one is no number.
double largest_deviation_mm(const RobotModel& nominal, std::span<const ControllerPose> poses);

/// A joint that alone explains why a nominal arm is not the controller's.
struct JointMistake {
  int joint = 0;     ///< index, 0 = first
  std::string what;  ///< "joint 4 turns the other way", "joint 2 has its zero 90.00 deg off"
};

/// The mistakes in the sign or the zero of one joint that bring the nominal arm to within `tolerance_mm` of
/// the controller at every pose. Several, where the poses cannot tell them apart; none, where it is not that.
std::vector<JointMistake> joint_mistakes(const RobotModel& nominal, std::span<const ControllerPose> poses,
                                         double tolerance_mm);

}  // namespace truepose
