#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/arm/robot_model.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

/// Whether this is the arm and the cycle that we were told.
class ArmCheck {
 public:
  /// @param max_deviation_mm  of RIst from the nominal arm's flange at AIPos
  ArmCheck(const RobotModel& nominal, std::chrono::milliseconds cycle, double max_deviation_mm);

  void restart() noexcept { wait_ = 0; }
  /// @param step  of the IPOC from cycle to cycle, where it is known; else 0
  /// @return WrongCycle or nothing
  std::optional<FoundFault> cycle(std::uint64_t step) const noexcept;
  /// At the beginning of a session, then once a second.
  /// @param elapsed  cycles since the frame before
  /// @return WrongArm or nothing
  std::optional<FoundFault> arm(const rsi::RobotFrame& frame, std::uint64_t elapsed) noexcept;

 private:
  const RobotModel nominal_;
  std::uint64_t cycle_ms_;
  double second_cycles_;
  double max_deviation_mm_;
  double wait_ = 0;  // cycles
};

}  // namespace truepose::daemon
