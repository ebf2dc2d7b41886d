#pragma once

#include <string>

namespace truepose::daemon {

/// What is wrong, and what an operator does about it.
struct FaultText {
  std::string what;
  std::string what_to_do{};  ///< about the cause; empty: `what` ends with it
};

/// One sentence: "robot: it is gone; look at its cable, then acknowledge".
/// @param then  what follows once the cause is gone
inline std::string sentence(const FaultText& fault, const std::string& then) {
  return fault.what + "; " + (fault.what_to_do.empty() ? "" : fault.what_to_do + ", ") + "then " + then;
}

}  // namespace truepose::daemon
