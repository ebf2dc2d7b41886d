#pragma once

#include <vector>

#include "tools/sim/krl/program.hpp"

namespace truepose::sim::krl {

/// The data of all modules, which all interpreters share and which outlives their programs. Begins with the
/// values that the data lists give.
struct Memory {
  /// Throws Fault: an initial value that does not fit.
  explicit Memory(const Program& program);

  std::vector<Value> globals;
};

}  // namespace truepose::sim::krl
