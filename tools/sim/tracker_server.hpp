#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

#include "tools/sim/tracker_beam.hpp"

namespace truepose::sim {

/// How a simulated tracker is set up, whatever it speaks.
struct TrackerServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;   ///< 0 picks a free one
  double speedup = 1;       ///< initialising, driving, searching and measuring take this much less time
  bool power_lock = false;  ///< locks by itself to a reflector that it sees
  TrackerInstrument instrument;
  /// Called with the number of each point, from 1, before it is measured.
  std::function<void(std::uint64_t number)> before_point = [](std::uint64_t) {};
};

/// A simulated tracker that listens on a port.
class TrackerServer {
 public:
  virtual ~TrackerServer() = default;
  virtual std::uint16_t port() const = 0;
  /// Points that have been measured so far.
  virtual std::uint64_t measurements() const = 0;

  virtual void disturb(const TrackerDisturbance& disturbance) = 0;
  /// Fault: something stands in the beam for this long (not scaled by the speed-up).
  virtual void beam_break(std::chrono::milliseconds duration) = 0;
  /// Fault: the controller restarts: the connection is cut and the tracker has to be initialised again.
  virtual void restart() = 0;
};

}  // namespace truepose::sim
