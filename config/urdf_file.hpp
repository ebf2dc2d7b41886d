#pragma once

#include <string>

#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// The arm as URDF (m, rad): base_link, link_1 .. link_N and flange, joined by joint_1 .. joint_N and the
/// fixed joint_flange. Kinematics alone: no masses or shapes, and a
/// comment says so where joints deviate or a residual field is left out. The frames are
/// forward_kinematics()'s, and each number has the digits that bring it back exactly.
std::string urdf(const RobotModel& robot);

}  // namespace truepose::config
