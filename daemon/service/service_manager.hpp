#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/threads/worker.hpp"
#include "drivers/clock.hpp"

namespace truepose::daemon {

// Notifications to systemd (sd_notify). Without a service manager nothing happens.

/// The sockets are bound and requests are served.
void notify_ready(std::string_view status);
void notify_stopping();

/// Within which time the service manager wants to hear notify_watchdog() again, before it kills and restarts
/// us; nothing where it does not watch.
std::optional<std::chrono::microseconds> watchdog_period();
void notify_watchdog();

/// Checks that all threads make progress. Only then the service manager is notified.
class Watchdog {
 public:
  struct Thread {
    std::string name;
    std::chrono::milliseconds patience;  ///< how long it may work between two beats
    std::function<Pulse()> pulse;
  };
  Watchdog(std::vector<Thread> threads, drivers::TimePoint now);

  /// A thread as it was seen.
  struct Seen {
    std::string name;
    bool idle = false;              ///< it has nothing to do
    drivers::Duration still_for{};  ///< since it was seen to advance, or idle
    bool stuck = false;             ///< for longer than its patience
  };
  /// Looks at every thread; to be called several times within the shortest patience.
  std::vector<Seen> look(drivers::TimePoint now);
  /// The same. @return the first that is stuck
  std::optional<std::string> stuck(drivers::TimePoint now);

 private:
  struct Watched {
    Thread thread;
    std::uint64_t beats;
    drivers::TimePoint advanced;
  };
  std::vector<Watched> watched_;
};

}  // namespace truepose::daemon
