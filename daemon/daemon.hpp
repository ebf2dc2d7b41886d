#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "config/cell_config.hpp"

namespace truepose::daemon {

/// The daemon cannot start: a port that is taken, a store that cannot be opened. what() is the one line.
class StartError : public std::runtime_error {
 public:
  explicit StartError(const std::string& sentence, bool may_pass = false)
      : std::runtime_error{sentence}, may_pass_{may_pass} {}
  /// Waiting may help: an address that is not there yet, a port in use, a full disk.
  bool may_pass() const { return may_pass_; }

 private:
  bool may_pass_;
};

/// Runs the cell until SIGTERM or SIGINT: corrections are ramped out, a campaign is aborted and recorded,
/// sockets are closed. Throws StartError.
///
/// @param warnings  about the configuration, for the log once the cell runs: a start that fails says one line
/// alone
void run(const config::CellConfig& config, const std::vector<std::string>& warnings);

}  // namespace truepose::daemon
