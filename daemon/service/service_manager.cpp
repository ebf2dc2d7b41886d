#include "daemon/service/service_manager.hpp"

#include <systemd/sd-daemon.h>

#include <utility>

namespace truepose::daemon {

void tell_ready(std::string_view status) { sd_notify(0, ("READY=1\nSTATUS=" + std::string{status}).c_str()); }
std::optional<std::chrono::microseconds> watchdog_period() {
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(0, &period_us) <= 0) return std::nullopt;
  return std::chrono::microseconds{period_us};
}
void tell_alive() { sd_notify(0, "WATCHDOG=1"); }
void tell_stopping() { sd_notify(0, "STOPPING=1\nSTATUS=stopping"); }

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
