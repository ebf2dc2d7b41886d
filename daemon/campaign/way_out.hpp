#pragma once

#include <string>

#include "config/cell_config.hpp"
#include "drivers/robot.hpp"
#include "drivers/tracker.hpp"

namespace truepose::daemon {

/// What an operator does about a device that fails in this way.
std::string way_out(drivers::RobotFault fault);
std::string way_out(drivers::TrackerFault fault, const config::TrackerConfig& tracker);

}  // namespace truepose::daemon
