#include "daemon/service/watchdog.hpp"

#include <utility>

namespace truepose::daemon {

Watchdog::Watchdog(std::vector<Thread> threads, drivers::TimePoint now) {
  for (Thread& thread : threads) {
    const std::uint64_t beats = thread.pulse().beats;
    watched_.push_back({std::move(thread), beats, now});
  }
}

std::optional<std::string> Watchdog::stuck(drivers::TimePoint now) {
  std::optional<std::string> first;
  for (Watched& watched : watched_) {
    const Pulse pulse = watched.thread.pulse();
    if (pulse.idle || pulse.beats != watched.beats) {
      watched.beats = pulse.beats;
      watched.advanced = now;
    }
    if (!first && now - watched.advanced > watched.thread.patience) first = watched.thread.name;
  }
  return first;
}

}  // namespace truepose::daemon
