#pragma once

#include "core/kinematics/robot_model.hpp"

namespace truepose {

/// The KR 210 R2700-2 of the method's paper as its data sheet has it (its Table 1, with the zero positions,
/// signs, limits and speeds of the controller's axes), without masses.
RobotModel published_arm();

}  // namespace truepose
