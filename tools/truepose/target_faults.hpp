#pragma once

#include <string>

#include "core/compensation/target_compensation.hpp"

namespace truepose::tools {

/// "joint 4 would have to go to 352.1 deg, its limits are -350..350"
/// @param robot  whose limits they are
std::string described(const CompensationFault& fault, const RobotModel& robot);

}  // namespace truepose::tools
