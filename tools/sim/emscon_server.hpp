#pragma once

#include <Eigen/Core>
#include <boost/asio/any_io_executor.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/simulate/tracker_instrument.hpp"

namespace truepose::sim {

/// What the simulated tracker could see at one moment.
struct TargetSight {
  /// True centre of the SMR in the tracker's frame, mm; nothing while the beam cannot return from it (turned
  /// out of its acceptance cone, or hidden by the arm).
  std::optional<Eigen::Vector3d> p_WS_mm;
  bool moving = false;                          ///< the arm is not standing still
  std::chrono::steady_clock::time_point stamp;  ///< the moment this is true for
};

/// The one SMR that the simulated arm carries. Asked from the tracker's executor; must not block.
class SimulatedTarget {
 public:
  virtual ~SimulatedTarget() = default;
  virtual TargetSight look() const = 0;
};

/// One measured point of a target that truly stands at `p_true_mm`: its scatter is that of the whole
/// measurement, not of the single readings that it averages. mm, tracker frame.
using TrackerNoise = std::function<Eigen::Vector3d(const Eigen::Vector3d& p_true_mm)>;

struct EmsconServerOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;   ///< 0 picks a free one
  double speedup = 1;       ///< initialising, driving, searching and measuring take this much less time
  bool power_lock = false;  ///< locks by itself to a reflector that it sees
  TrackerInstrument instrument;
  /// Called with the number of each point, from 1, before it is measured.
  std::function<void(std::uint64_t number)> before_point = [](std::uint64_t) {};
};

/// In what a tracker is wrong, or says wrong things.
struct TrackerDisturbance {
  Eigen::Vector3d moved_mm{0, 0,
                           0};  ///< by which all that it sees has moved since it was set up: it was pushed
  Eigen::Vector3d bias_mm{0, 0, 0};  ///< of what it measures
  std::optional<double> std_mm;      ///< that it reports for each axis, whatever it is
  bool busy = false;                 ///< with what somebody else asked for: refuses every command
  bool silent = false;               ///< answers and reports nothing
  bool storms = false;               ///< reports changes of its state without end
  double temperature_c = 20, pressure_mbar = 1013.25, humidity_percent = 50;  ///< that it reports
};

/// The status of the Error that a broken beam ends a measurement with. Invented: the real number is not
/// public.
inline constexpr std::int32_t kSimulatedBeamBroken = 20001;
/// The status of a FindReflector that found nothing. Invented likewise.
inline constexpr std::int32_t kSimulatedNoTarget = 20002;

/// A simulated laser tracker: an emScon TCP server that follows one target.
///
/// Initialising takes 20 s, driving 1 s, a search up to its timeout, a measurement the time that was set; all
/// of it divided by the speed-up. Once lost, a reflector is locked again only by FindReflector, within the
/// search radius of the point that was driven to. Serves one client; a second one gets status 10011 and is
/// closed. Runs on the executor it is given (one thread or a strand); destroy it there, or when that no
/// longer runs.
class EmsconServer {
 public:
  /// Listens at once. Throws boost::system::system_error when the port cannot be bound.
  /// @param target  outlives the server
  EmsconServer(boost::asio::any_io_executor executor, const SimulatedTarget& target, TrackerNoise noise,
               EmsconServerOptions options);
  ~EmsconServer();

  std::uint16_t port() const;
  /// Points that have been measured so far.
  std::uint64_t measurements() const;

  void disturb(const TrackerDisturbance& disturbance);
  /// Fault: something stands in the beam for this long (not scaled by the speed-up).
  void beam_break(std::chrono::milliseconds duration);
  /// Fault: the controller restarts: the connection is cut and the tracker has to be initialised again.
  void restart();

 private:
  class State;
  std::shared_ptr<State> state_;
};

}  // namespace truepose::sim
