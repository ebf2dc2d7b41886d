#pragma once

#include <cstdint>
#include <optional>

#include "daemon/realtime/controller_session.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "drivers/clock.hpp"

namespace truepose::daemon {

/// Looks for replies that were sent in time and not taken.
class LateReplies {
 public:
  /// @param rejected_cycles  so many late replies in a row that were sent in time are a fault
  explicit LateReplies(int rejected_cycles) : rejected_cycles_{rejected_cycles} {}

  void restart() noexcept { rejected_ = 0; }
  /// A datagram that came at `received` was dealt with at `done`, whether it was answered or not.
  void dealt_with(drivers::TimePoint received, drivers::TimePoint done) noexcept {
    received_ = received;
    turnaround_ = done - received;
  }
  /// @return RepliesRejected or nothing
  std::optional<FoundFault> take(const ControllerSession::Hearing& hearing,
                                 drivers::TimePoint received) noexcept;
  /// Whether the last frame was the first of a row that told of late replies.
  bool began() const noexcept { return began_; }

 private:
  int rejected_cycles_;
  std::optional<drivers::TimePoint> received_;
  drivers::Duration turnaround_{0};
  int rejected_ = 0;  // in a row
  bool late_before_ = false;
  bool began_ = false;
};

}  // namespace truepose::daemon
