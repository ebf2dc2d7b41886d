#include "daemon/realtime/missing_elements.hpp"

namespace truepose::daemon {

MissingElements::MissingElements(const rsi::EthernetConfig& ethernet) noexcept {
  for (Watched& watched : watched_) watched.sent = ethernet.sends(watched.element);
}

void MissingElements::restart() noexcept {
  for (Watched& watched : watched_) watched.missing_cycles = 0;
}

std::string_view MissingElements::take(const rsi::RobotFrame& frame, double cycles, double limit) noexcept {
  const std::array<bool, 3> there{frame.delay.has_value(), frame.aipos_rad.has_value(),
                                  frame.rist.has_value()};
  std::string_view missing;
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    Watched& watched = watched_[i];
    watched.missing_cycles = there[i] ? 0 : watched.missing_cycles + cycles;
    if (missing.empty() && watched.sent && watched.missing_cycles >= limit) missing = watched.element;
  }
  return missing;
}

}  // namespace truepose::daemon
