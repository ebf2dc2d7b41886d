#pragma once

#include <string>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// A nominal arm as the text of a robot file, which load_robot() reads back to the same arm.
///
/// @param comment  lines that stand in front of it, each behind "# "
std::string robot_text(const RobotModel& robot, const std::vector<std::string>& comment);

/// "{joint: 3, to: 2, factor: 1}"
std::string coupling_text(const JointCoupling& coupling);

}  // namespace truepose::config
