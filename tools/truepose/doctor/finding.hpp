#pragma once

#include <string>
#include <vector>

namespace truepose::tools {

enum class Level { Ok, Warning, Fault };

/// What the doctor says of one thing.
struct Finding {
  std::string area;  ///< "cell file", "daemon", "rsi", "robot", "tracker", "machine"
  Level level = Level::Ok;
  std::string finding;  ///< one sentence
  std::string next;     ///< what to do; empty where all is well
  /// It may follow from a fault of its area: where one is named, this is not said.
  bool may_follow = false;
};

using Findings = std::vector<Finding>;

}  // namespace truepose::tools
