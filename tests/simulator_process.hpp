#pragma once

#include <string>
#include <vector>

#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::sim {

/// truepose-sim as its users start it.
class SimulatorProcess : public Process {
 public:
  SimulatorProcess(const TempFolder& folder, std::vector<std::string> arguments)
      : Process{folder.path(), "truepose-sim", std::move(arguments)} {}
};

}  // namespace truepose::sim
