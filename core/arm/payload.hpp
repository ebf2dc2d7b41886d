#pragma once

#include <expected>
#include <string>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// A calibrated arm with this payload in place of its own. Errors, as a sentence: the model does not know how
/// it bends under one.
std::expected<RobotModel, std::string> carrying(RobotModel robot, const LinkMass& payload);

}  // namespace truepose
