#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "config/cell_config.hpp"

namespace truepose::daemon {

/// What the check of a cell found.
struct CheckFinding {
  enum class Level { Good, Warning, Failure };
  Level level;
  std::string text;       ///< one line: what, where, and what to do about it
  bool may_pass = false;  ///< by itself: a clock that is wrong at boot is corrected
};

/// Looks at everything that a cell's configuration names beyond itself. Changes nothing.
/// @param now  by which certificates hold
std::vector<CheckFinding> check(const config::CellConfig& config,
                                std::chrono::system_clock::time_point now = std::chrono::system_clock::now());

}  // namespace truepose::daemon
