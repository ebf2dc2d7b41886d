#pragma once

#include <chrono>
#include <optional>

#include "drivers/clock.hpp"
#include "drivers/tracker.hpp"

namespace truepose::drivers {

/// What is known of how warm a tracker is.
struct WarmUpMemory {
  std::optional<TimePoint> cold_since;
  bool warmed_up = false;
};

/// When a tracker that was initialised cold is to be initialised once more: where it says that it has warmed
/// up, or so long after it was found switched on.
class InitialiseAgain {
 public:
  /// @param clock   outlives it
  /// @param after   0: where it says so alone
  /// @param memory  that it goes on from
  InitialiseAgain(const Clock& clock, std::chrono::minutes after, const WarmUpMemory& memory = {})
      : clock_{clock}, after_{after}, memory_{memory} {}

  const WarmUpMemory& memory() const { return memory_; }

  /// It was not initialised when it was connected: somebody has just switched it on.
  void found_cold() { memory_.cold_since = clock_.now(); }
  /// It says so.
  void has_warmed_up() { memory_.warmed_up = true; }
  bool warmed_up() const { return memory_.warmed_up; }

  /// When it is connected the next time.
  bool is_due() const { return memory_.warmed_up || time_is_over(); }
  /// It was initialised.
  void done() {
    if (is_due()) memory_.cold_since.reset();
    memory_.warmed_up = false;
  }

  /// What is not measured before that.
  static TrackerError refusal() {
    return {TrackerFault::NotReady,
            "the tracker has warmed up, and is to be connected and initialised again"};
  }

 private:
  bool time_is_over() const {
    return after_.count() > 0 && memory_.cold_since && clock_.now() - *memory_.cold_since >= after_;
  }

  const Clock& clock_;
  std::chrono::minutes after_;
  WarmUpMemory memory_;
};

}  // namespace truepose::drivers
