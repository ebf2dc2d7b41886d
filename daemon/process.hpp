#pragma once

#include <string>
#include <vector>

#include "config/cell_config.hpp"

namespace truepose::daemon {

/// Runs the cell in this process until SIGTERM or SIGINT, and SIGHUP where that is not ignored (nohup).
/// Throws StartError.
///
/// @param warnings  about the configuration, for the log once the cell runs: a start that fails says one line
/// alone
void run(const config::CellConfig& config, const std::vector<std::string>& warnings);

}  // namespace truepose::daemon
