#pragma once

#include <string>

#include "core/compensation/pose_inverse.hpp"

namespace truepose::tools {

std::string described(PoseInverseFault fault);

/// "joint 4 would have to go to 352.1 deg, its limits are -350..350", or nothing where all is within the
/// limits.
std::string beyond_limits(const RobotModel& robot, const JointVector& q);

}  // namespace truepose::tools
