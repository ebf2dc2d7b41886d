#include "daemon/realtime/missing_elements.hpp"

namespace truepose::daemon {

MissingElements::MissingElements(const rsi::EthernetConfig& ethernet, double limit_cycles) noexcept
    : limit_cycles_{limit_cycles} {
  for (Watched& watched : watched_) watched.sent = ethernet.sends(watched.element);
}

void MissingElements::restart() noexcept {
  for (Watched& watched : watched_) watched.missing_cycles = 0;
}

std::optional<FoundFault> MissingElements::take(const rsi::RobotFrame& frame,
                                                std::uint64_t elapsed) noexcept {
  const std::array<bool, 3> there{frame.delay.has_value(), frame.aipos_rad.has_value(),
                                  frame.rist.has_value()};
  std::optional<FoundFault> missing;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watched& watched = watched_[i];
    watched.missing_cycles = there[i] ? 0 : watched.missing_cycles + static_cast<double>(elapsed);
    if (!missing && watched.sent && watched.missing_cycles >= limit_cycles_)
      missing = FoundFault{StreamFault::NotSent, {.element = watched.element}};
  }
  return missing;
}

}  // namespace truepose::daemon
