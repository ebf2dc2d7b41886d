#pragma once

#include <string>

namespace truepose::daemon {

/// What a failure asks for.
enum class Remedy {
  Retry,  ///< the device is fine, the attempt was not
  ReconnectRobot,
  ReconnectTracker,
  WaitForRobot,  ///< connected, but it may not move
  WrongArm,      ///< not the configured one: nothing that a repeat would change
};

struct DeviceError {
  Remedy remedy;
  std::string detail;        ///< one sentence for the operator
  bool beam_lost = false;    ///< no reflector was seen, or not to the end
  std::string what_to_do{};  ///< about the cause; empty: the detail ends with it
};

}  // namespace truepose::daemon
