#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "core/arm/robot_model.hpp"
#include "daemon/realtime/controller_session.hpp"
#include "daemon/realtime/effect_watch.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "drivers/clock.hpp"
#include "proto/rsi/ethernet_config.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose::daemon {

/// Whether this is the configured arm and cycle.
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

/// Looks for elements by which the stream is watched and that the controller does not send although its
/// configuration, as we read it, does: then it loaded another one. The realtime thread's own.
class MissingElements {
 public:
  /// @param limit_cycles  for so long an element may be missing
  MissingElements(const rsi::EthernetConfig& ethernet, double limit_cycles) noexcept;

  void restart() noexcept;
  /// @param elapsed  cycles since the frame before
  /// @return NotSent or nothing
  std::optional<FoundFault> take(const rsi::RobotFrame& frame, std::uint64_t elapsed) noexcept;

 private:
  struct Watched {
    std::string_view element;
    bool sent = false;
    double missing_cycles = 0;
  };
  double limit_cycles_;
  std::array<Watched, 3> watched_{{{.element = "Delay"}, {.element = "AIPos"}, {.element = "RIst"}}};
};

/// Whether the arm does what is sent, in motion too.
class FollowingCheck {
 public:
  FollowingCheck(double cycle_ms, double tolerance_rad) : effect_{cycle_ms}, tolerance_rad_{tolerance_rad} {}

  /// What came so far counts no more.
  void restart() noexcept;
  /// Nor does what was learned of the arm's lag: of an arm that was held by its brakes, or did something else
  /// than it was sent, that is none.
  void forget() noexcept;
  /// @param correction  in effect when the frame was sent
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

/// Looks for replies that were sent in time and not taken, in a session that never took one: later the
/// network has lost them, which passes or ends the session.
class LateReplies {
 public:
  /// @param rejected_cycles  so many late replies in a row that were sent in time are a fault
  explicit LateReplies(int rejected_cycles) : rejected_cycles_{rejected_cycles} {}

  void restart() noexcept {
    rejected_ = 0;
    believed_ = false;
  }
  /// A datagram was dealt with, whether it was answered or not.
  void dealt_with(const drivers::CycleTimes& times) noexcept {
    received_ = times.received;
    turnaround_ = times.sent - times.received;
  }
  /// @return RepliesRejected or nothing
  std::optional<FoundFault> take(const ControllerSession::FrameVerdict& verdict,
                                 drivers::TimePoint received) noexcept;
  /// Whether the last frame was the first of a row that reported late replies.
  bool began() const noexcept { return began_; }

 private:
  int rejected_cycles_;
  std::optional<drivers::TimePoint> received_;
  drivers::Duration turnaround_{0};
  int rejected_ = 0;       // in a row
  bool believed_ = false;  // a reply was taken
  bool late_before_ = false;
  bool began_ = false;
};

}  // namespace truepose::daemon
