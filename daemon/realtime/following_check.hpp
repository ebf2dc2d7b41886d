#pragma once

#include <array>
#include <optional>

#include "daemon/realtime/effect_watch.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

/// Whether the arm does what is sent, in motion too.
class FollowingCheck {
 public:
  FollowingCheck(double cycle_ms, double tolerance_rad) : effect_{cycle_ms}, tolerance_rad_{tolerance_rad} {}

  /// What came so far counts no more.
  void restart() noexcept;
  /// @param correction  in force when the frame was sent
  /// @param elapsed     cycles since the frame before
  /// @return NotFollowing or nothing
  std::optional<FoundFault> take(const rsi::RobotFrame& frame, const JointVector& correction,
                                 std::uint64_t elapsed) noexcept;

  /// The correction as measured over the last second, deg; none where lag and motion leave it uncertain.
  const std::array<std::optional<double>, 6>& measured_deg() const noexcept { return measured_deg_; }

 private:
  EffectWatch effect_;
  double tolerance_rad_;
  int not_following_ = 0;  // judgements in a row
  std::array<std::optional<double>, 6> measured_deg_{};
};

}  // namespace truepose::daemon
