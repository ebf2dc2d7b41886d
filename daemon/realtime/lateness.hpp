#pragma once

#include <cstdint>
#include <optional>

#include "drivers/clock.hpp"
#include "drivers/kuka/rsi_link.hpp"

namespace truepose::daemon {

enum class LateBy : std::uint8_t {
  Daemon,   ///< the reply took long to compute
  Machine,  ///< the thread was woken late, kept from running, or waited for the socket
  Network,  ///< the datagram came late against the controller's own count
};

/// Tells whose doing it is that a reply leaves late: more than half a cycle after its datagram was due. The
/// controller reads it at the end of the cycle, and the way there and back needs the other half. The one
/// whose part of the delay is the greatest is named; a datagram that waited for the one before it is late by
/// the part that delayed that one.
///
/// Due is what the earliest datagrams and the IPOC say, a line that may rise by kDrift: no two clocks differ
/// by so much. Where kUsual datagrams in a row come late, the controller or its way has changed: the earliest
/// of them is in time from then on. The realtime thread's own.
class Lateness {
 public:
  /// @param cycle  the controller's
  explicit Lateness(drivers::Duration cycle) : cycle_{cycle} {}

  /// The next good frame begins a count of its own.
  void restart() noexcept {
    due_.reset();
    behind_ = 0;
  }
  /// @param elapsed  cycles since the good frame before
  void heard(drivers::TimePoint received, std::uint64_t elapsed) noexcept;
  /// The datagram that was received last is answered. @return nothing if its reply left in time
  std::optional<LateBy> judge(const drivers::CycleTimes& times) noexcept;

 private:
  static constexpr int kDrift = 1000;  // a cycle may last longer by one part in so many
  static constexpr int kUsual = 25;

  drivers::Duration cycle_;
  std::optional<drivers::TimePoint> due_;
  int behind_ = 0;  // datagrams in a row
  drivers::Duration least_behind_{0};
  drivers::TimePoint busy_until_{};  // with the datagram before
  LateBy held_up_ = LateBy::Machine;
};

}  // namespace truepose::daemon
