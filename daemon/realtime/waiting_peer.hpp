#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "drivers/clock.hpp"

namespace truepose::daemon {

/// Recognises a peer that waits for a reply before it continues: it repeats its frame, after 40 ms or a
/// second, and its IPOC counts replies. Simulators of the robot's side are such; a controller sends the next
/// IPOC after 4 or 12 ms whatever comes.
///
/// A repeated datagram of a controller comes of the network, at once or out of a queue, with others behind
/// it: so a frame counts as repeated only after a time in which a controller had sent several, and only where
/// nothing else came meanwhile.
class WaitingPeer {
 public:
  /// @param ipoc  of a frame of the controller, wherever in its count that is
  void take(std::uint64_t ipoc, drivers::TimePoint received) noexcept {
    if (ipoc_ != ipoc) {
      ipoc_ = ipoc;
      repeats_ = 0;
    } else if (received - received_ >= kSpacing) {
      ++repeats_;
    }
    received_ = received;
  }
  void restart() noexcept { ipoc_.reset(); }

  bool waits() const noexcept { return ipoc_ && repeats_ >= kRepeats; }

 private:
  static constexpr std::chrono::milliseconds kSpacing{30};  // two cycles of 12 ms, and some of one more
  static constexpr int kRepeats = 2;                        // one may be a queue's

  std::optional<std::uint64_t> ipoc_;
  drivers::TimePoint received_;
  int repeats_ = 0;
};

}  // namespace truepose::daemon
