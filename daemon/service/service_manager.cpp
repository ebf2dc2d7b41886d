#include "daemon/service/service_manager.hpp"

#include <systemd/sd-daemon.h>

#include <algorithm>
#include <utility>

namespace truepose::daemon {

void notify_ready(std::string_view status) {
  sd_notify(0, ("READY=1\nSTATUS=" + std::string{status}).c_str());
}
std::optional<std::chrono::microseconds> watchdog_period() {
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(0, &period_us) <= 0) return std::nullopt;
  return std::chrono::microseconds{period_us};
}
void notify_watchdog() { sd_notify(0, "WATCHDOG=1"); }
void notify_stopping() { sd_notify(0, "STOPPING=1\nSTATUS=stopping"); }

Watchdog::Watchdog(std::vector<Thread> threads, drivers::TimePoint now) {
  for (Thread& thread : threads) {
    const std::uint64_t beats = thread.pulse().beats;
    watched_.push_back({std::move(thread), beats, now});
  }
}

std::vector<Watchdog::Seen> Watchdog::look(drivers::TimePoint now) {
  std::vector<Seen> all;
  for (Watched& watched : watched_) {
    const Pulse pulse = watched.thread.pulse();
    if (pulse.idle || pulse.beats != watched.beats) {
      watched.beats = pulse.beats;
      watched.advanced = now;
    }
    const drivers::Duration still_for = now - watched.advanced;
    all.push_back({watched.thread.name, pulse.idle, still_for, still_for > watched.thread.patience});
  }
  return all;
}

std::optional<std::string> Watchdog::stuck(drivers::TimePoint now) {
  const std::vector<Seen> all = look(now);
  const auto first = std::ranges::find(all, true, &Seen::stuck);
  return first == all.end() ? std::nullopt : std::optional{first->name};
}

}  // namespace truepose::daemon
