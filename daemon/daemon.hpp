#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "config/cell_config.hpp"

namespace truepose::daemon {

/// The daemon cannot start: a port that is taken, a store that cannot be opened. what() is the one line.
class StartError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Runs the cell until SIGTERM or SIGINT: corrections are ramped out, a campaign is aborted and recorded,
/// sockets are closed. Throws StartError.
///
/// @param warnings  about the configuration, for the log once the cell runs: a start that fails says one line
/// alone
void run(const config::CellConfig& config, const std::vector<std::string>& warnings);

}  // namespace truepose::daemon
