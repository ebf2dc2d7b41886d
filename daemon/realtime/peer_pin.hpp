#pragma once

#include <optional>

#include "drivers/kuka/rsi_link.hpp"

namespace truepose::daemon {

/// Whose datagrams are the controller's: those from its address, and of these from the one port that its
/// session began with. Another port is heard only when that one has been silent for as long as a controller
/// needs to begin anew.
class PeerPin {
 public:
  /// @param address  the controller's, IPv4; none: the first that sends a good frame
  PeerPin(std::optional<std::uint32_t> address, drivers::Duration release)
      : address_{address}, release_{release} {}

  bool admits(const drivers::UdpSource& source, drivers::TimePoint now) const noexcept {
    if (address_ && source.address != *address_) return false;
    return !pinned_ || source == *pinned_ || now - heard_ >= release_;
  }

  /// An admitted source has sent a frame that can be believed.
  /// @return whether it is another one than before
  bool pin(const drivers::UdpSource& source, drivers::TimePoint now) noexcept {
    const bool other = pinned_ != source;
    pinned_ = source;
    heard_ = now;
    return other;
  }

  const std::optional<drivers::UdpSource>& pinned() const noexcept { return pinned_; }
  drivers::TimePoint heard() const noexcept { return heard_; }

 private:
  std::optional<std::uint32_t> address_;
  drivers::Duration release_;
  std::optional<drivers::UdpSource> pinned_;
  drivers::TimePoint heard_;
};

}  // namespace truepose::daemon
