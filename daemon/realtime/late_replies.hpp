#pragma once

#include <cstdint>
#include <optional>

#include "daemon/realtime/controller_session.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "drivers/clock.hpp"

namespace truepose::daemon {

/// Looks for replies that were sent in time and not taken, and for a controller that does not say.
class LateReplies {
 public:
  /// @param rejected_cycles  so many late replies in a row that were sent in time are a fault
  LateReplies(double second_cycles, int rejected_cycles)
      : second_cycles_{second_cycles}, rejected_cycles_{rejected_cycles} {}

  void restart() noexcept {
    without_delay_ = 0;
    rejected_ = 0;
  }
  /// A datagram that came at `received` was dealt with at `done`, whether it was answered or not.
  void dealt_with(drivers::TimePoint received, drivers::TimePoint done) noexcept {
    received_ = received;
    turnaround_ = done - received;
  }
  /// @return NoDelay, RepliesRejected or nothing
  std::optional<FoundFault> take(const rsi::RobotFrame& frame, const ControllerSession::Hearing& hearing,
                                 drivers::TimePoint received) noexcept;
  /// Whether the last frame was the first of a row that told of late replies.
  bool began() const noexcept { return began_; }

 private:
  double second_cycles_;
  int rejected_cycles_;
  std::optional<drivers::TimePoint> received_;
  drivers::Duration turnaround_{0};
  double without_delay_ = 0;  // cycles in a row
  int rejected_ = 0;          // in a row
  bool late_before_ = false;
  bool began_ = false;
};

}  // namespace truepose::daemon
