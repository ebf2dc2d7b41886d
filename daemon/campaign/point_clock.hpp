#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "drivers/clock.hpp"

namespace truepose::daemon {

/// When the points of a campaign are measured: by the wall clock at the first of them, and by the steady
/// clock from there on. A wall clock that is set meanwhile neither turns their order round nor makes an hour
/// of a minute, by which an arm that warms up would be taken for one that does not.
class PointClock {
 public:
  /// @param before  when the last point was measured before an interruption (RFC 3339), which none comes
  ///                before; empty: there was none
  PointClock(drivers::WallClock wall_clock, const drivers::Clock& steady_clock, const std::string& before);

  std::chrono::system_clock::time_point now();

 private:
  struct Start {
    std::chrono::system_clock::time_point wall;
    drivers::TimePoint steady;
  };

  drivers::WallClock wall_clock_;
  const drivers::Clock& steady_clock_;
  std::optional<std::chrono::system_clock::time_point> before_;
  std::optional<Start> start_;  ///< of the first point
};

}  // namespace truepose::daemon
