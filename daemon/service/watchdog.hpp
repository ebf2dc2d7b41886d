#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "drivers/clock.hpp"

namespace truepose::daemon {

/// What a thread shows of itself.
struct Pulse {
  std::uint64_t beats = 0;  ///< rises while it advances
  bool idle = false;        ///< it has nothing to do, so nothing has to rise
};

/// Judges whether threads advance, so that the service manager is told so only where it is true.
class Watchdog {
 public:
  struct Thread {
    std::string name;
    std::chrono::milliseconds patience;  ///< how long it may work between two beats
    std::function<Pulse()> pulse;
  };
  Watchdog(std::vector<Thread> threads, drivers::TimePoint now);

  /// Looks at every thread; to be called several times within the shortest patience.
  /// @return the first that has stood still for longer than its patience
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
