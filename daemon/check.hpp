#pragma once

#include <string>
#include <vector>

#include "config/cell_config.hpp"

namespace truepose::daemon {

struct Finding {
  enum class Level { Good, Warning, Failure };
  Level level;
  std::string text;  ///< one line: what, where, and what to do about it
};

/// Looks at everything that a cell's configuration names beyond itself. Changes nothing.
std::vector<Finding> check(const config::CellConfig& config);

}  // namespace truepose::daemon
