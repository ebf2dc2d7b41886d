#pragma once

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign_result.hpp"

namespace truepose::daemon {

/// The cell while a tool is measured: the tracker stands where the model has it, and the reflectors sit at
/// the tool's points, by whose names they go. As far as the tool is known to reach it is kept clear of all
/// else.
config::CellConfig cell_with_tool(config::CellConfig cell, const ToolOrder& order);

}  // namespace truepose::daemon
