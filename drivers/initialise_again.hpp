#pragma once

#include <chrono>
#include <optional>

#include "drivers/clock.hpp"
#include "drivers/tracker.hpp"

namespace truepose::drivers {

/// When a tracker that was initialised cold is to be initialised once more: where it says that it has warmed
/// up, or so long after it was found switched on.
class InitialiseAgain {
 public:
  /// @param clock  outlives it
  /// @param after  0: where it says so alone
  InitialiseAgain(const Clock& clock, std::chrono::minutes after) : clock_{clock}, after_{after} {}

  /// It was not initialised when it was connected: it has just been switched on.
  void found_cold() { cold_since_ = clock_.now(); }
  /// It says so.
  void has_warmed_up() { warmed_up_ = true; }
  bool warmed_up() const { return warmed_up_; }

  /// When it is connected the next time.
  bool is_due() const { return warmed_up_ || time_is_over(); }
  /// It was initialised.
  void done() {
    if (is_due()) cold_since_.reset();
    warmed_up_ = false;
  }

  /// What is not measured before that.
  static TrackerError refusal() {
    return {TrackerFault::NotReady,
            "the tracker has warmed up, and is to be connected and initialised again"};
  }

 private:
  bool time_is_over() const {
    return after_.count() > 0 && cold_since_ && clock_.now() - *cold_since_ >= after_;
  }

  const Clock& clock_;
  std::chrono::minutes after_;
  std::optional<TimePoint> cold_since_;
  bool warmed_up_ = false;
};

}  // namespace truepose::drivers
