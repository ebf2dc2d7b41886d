#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "tools/sim/tracker/tracker_beam.hpp"

namespace truepose::sim {

/// How a simulated tracker is set up, whatever it speaks.
struct TrackerServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;   ///< 0 picks a free one
  double speedup = 1;       ///< initialising, driving, searching and measuring take this much less time
  bool power_lock = false;  ///< locks by itself to a reflector that it sees
  TrackerInstrument instrument;
  OrientationNoise orientation_noise{};  ///< of a 6-D target; empty: the arm carries a plain reflector
  /// Called with the number of each point, from 1, before it is measured.
  std::function<void(std::uint64_t number)> before_point = [](std::uint64_t) {};
};

class SimulatedTracker;

/// A simulated tracker that listens on a port, and serves one client. Destroy it on its machine's
/// executor, or when that does not run.
class TrackerServer {
 public:
  virtual ~TrackerServer();
  TrackerServer(const TrackerServer&) = delete;
  TrackerServer& operator=(const TrackerServer&) = delete;

  std::uint16_t port() const;
  /// Points that have been measured so far.
  std::uint64_t measurements() const;

  void disturb(const TrackerDisturbance& disturbance);
  /// Fault: something stands in the beam for this long (not scaled by the speed-up).
  void beam_break(std::chrono::milliseconds duration);
  /// Fault: the controller restarts: the connection is cut and the tracker has to be initialised again.
  void restart();

 protected:
  explicit TrackerServer(std::shared_ptr<SimulatedTracker> tracker);

 private:
  std::shared_ptr<SimulatedTracker> tracker_;
};

}  // namespace truepose::sim
