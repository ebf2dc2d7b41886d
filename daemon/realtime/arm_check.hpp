#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/kinematics/robot_model.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

/// Whether this is the arm and the cycle that we were told: at the beginning of a session, then once a
/// second.
class ArmCheck {
 public:
  /// @param max_deviation_mm  of RIst from the nominal arm's flange at AIPos
  ArmCheck(const RobotModel& nominal, std::chrono::milliseconds cycle, double max_deviation_mm);

  void restart() noexcept { wait_ = 0; }
  /// @param elapsed  cycles since the frame before
  /// @param step     of the IPOC from cycle to cycle, where it is known; else 0
  /// @return WrongCycle, WrongArm or nothing
  std::optional<FoundFault> take(const rsi::RobotFrame& frame, std::uint64_t elapsed,
                                 std::uint64_t step) noexcept;

 private:
  const RobotModel nominal_;
  std::uint64_t cycle_ms_;
  double second_cycles_;
  double max_deviation_mm_;
  double wait_ = 0;  // cycles
};

}  // namespace truepose::daemon
