#pragma once

#include <chrono>
#include <string>
#include <utility>

#include "drivers/leica/emscon_tracker.hpp"
#include "tests/tools/sim/tracker/tracker_over_loopback.hpp"
#include "tools/sim/tracker/emscon_server.hpp"

namespace truepose::sim {

/// The real driver against the simulated tracker over loopback, a thousand times faster than life.
class EmsconServerTest : public TrackerOverLoopback {
 protected:
  EmsconServerTest() : TrackerOverLoopback{20261121} {}

  drivers::EmsconOptions options(std::string reflector = "CCR-1.5in") const {
    return {.host = "127.0.0.1",
            .port = server.port(),
            .reflector = std::move(reflector),
            .measure = std::chrono::milliseconds{2000}};
  }

  auto connect() { return run(tracker.connect(soon())); }
  auto aim(double radius_mm = 50) { return run(tracker.aim(aim_mm, radius_mm, soon())); }
  auto measure() { return run(tracker.measure(soon())); }

  EmsconServer server{
      machine, target, [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm); }, {.speedup = 1000}};
  drivers::EmsconTracker tracker{io.get_executor(), clock, options()};
};

}  // namespace truepose::sim
