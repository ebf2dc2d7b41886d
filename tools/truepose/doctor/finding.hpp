#pragma once

#include <string>
#include <vector>

#include "tools/truepose/doctor/finding_kinds.hpp"

namespace truepose::tools {

enum class Level { Ok, Warning, Fault };

/// What the doctor says of one thing.
struct Finding {
  std::string area;  ///< "cell file", "daemon", "rsi", "robot", "tracker", "machine"
  Level level = Level::Ok;
  Message message;  ///< nothing to do where all is well
  /// It may follow from a fault of its area: where one is named, this is not said.
  bool may_follow = false;
};

using Findings = std::vector<Finding>;

template <FindingKind kKind, typename... Values>
Finding finding(std::string area, Level level, const Values&... values) {
  return {std::move(area), level, message<kKind>(values...)};
}

/// All is well there.
inline Finding good(std::string area, std::string fact) {
  return {std::move(area), Level::Ok, {"D_OK", std::move(fact), ""}};
}

}  // namespace truepose::tools
