#pragma once

#include "config/cell_config.hpp"
#include "daemon/campaign/campaign_result.hpp"

namespace truepose::daemon {

/// The cell while a tool is measured: the tracker stands where the model has it, and the reflectors sit at
/// the tool's points, by whose names they go.
config::CellConfig cell_with_tool(config::CellConfig cell, const ToolOrder& order);

/// Why points of these names and coordinates tell no frame of a tool; empty: they do.
std::string why_no_frame(const ToolOrder& order);

}  // namespace truepose::daemon
