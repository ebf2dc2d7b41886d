#pragma once

#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// An arm from a file of another program.
struct ImportedArm {
  RobotModel robot;
  /// What was taken for what, and what the source does not say: sentences for the user and for the robot
  /// file's comment.
  std::vector<std::string> notes;
};

/// Limits and speed where a source has none: a whole turn (1 m) to either side at 100 deg/s (mm/s).
inline void assume_limits(Joint& joint) {
  const bool revolute = joint.type == JointType::Revolute;
  const double full = revolute ? 6.283185307179586 : 1000, unit = revolute ? full / 360 : 1;
  if (!(joint.min < joint.max)) {
    joint.min = -full;
    joint.max = full;
  }
  if (!(joint.speed > 0)) joint.speed = 100 * unit;
}

}  // namespace truepose::config
