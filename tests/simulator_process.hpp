#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::sim {

/// truepose-sim as its users start it.
class SimulatorProcess : public Process {
 public:
  SimulatorProcess(const TempFolder& folder, std::vector<std::string> arguments)
      : Process{folder.path(), "truepose-sim", std::move(arguments)} {}

  /// The ready file's text, or nothing if the simulator ended instead of writing it.
  std::string ready(const std::filesystem::path& file) {
    while (!std::filesystem::exists(file)) {
      if (ended()) return {};
      std::this_thread::sleep_for(std::chrono::milliseconds{2});
    }
    return text_of(file);
  }
};

}  // namespace truepose::sim
