#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "config/cell_config.hpp"

namespace truepose::daemon {

/// The folder that recordings are written to, of which the oldest are removed where they become too many or
/// too large.
class RecordingFolder {
 public:
  explicit RecordingFolder(const config::RecordingConfig& config) : config_{config} {}

  /// For the ring, and the header that belongs to it.
  std::filesystem::path ring() const { return config_.folder / "ring"; }
  std::filesystem::path ring_header() const { return config_.folder / "ring.header"; }
  /// Why no recording can be written: one line that says what, where and what to do; empty: one can.
  std::string why_unusable() const;
  /// Of a recording that is written next, at this time, RFC 3339.
  std::filesystem::path file(const std::string& date) const;

  struct Entry {
    std::string name;
    std::uintmax_t bytes = 0;
  };
  /// The last made first, whatever the clock said.
  std::vector<Entry> list() const;
  /// The file of a recording; empty where there is none of that name.
  std::filesystem::path find(const std::string& name) const;
  /// Removes what is too much, but never the last made. @return their names
  std::vector<std::string> prune() const;
  /// Removes what daemons that were killed while they wrote have left. @return their names
  std::vector<std::string> remove_left_over() const;

 private:
  config::RecordingConfig config_;
};

}  // namespace truepose::daemon
