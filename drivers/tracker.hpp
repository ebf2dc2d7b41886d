#pragma once

#include <Eigen/Core>
#include <array>
#include <boost/asio/awaitable.hpp>
#include <expected>
#include <optional>
#include <string>

#include "core/data/measurement.hpp"
#include "drivers/clock.hpp"

namespace truepose::drivers {

enum class TrackerFault {
  Unreachable,
  Timeout,
  Disconnected,
  Protocol,
  NotReady,    ///< not initialised, not warmed up, another mode
  NoTarget,    ///< the search found no reflector
  BeamBroken,  ///< lost during the measurement
  Busy,
  Refused,
};

inline constexpr std::array kTrackerFaults{
    TrackerFault::Unreachable, TrackerFault::Timeout,  TrackerFault::Disconnected,
    TrackerFault::Protocol,    TrackerFault::NotReady, TrackerFault::NoTarget,
    TrackerFault::BeamBroken,  TrackerFault::Busy,     TrackerFault::Refused};

/// Whether a new connection is needed.
constexpr bool is_lost(TrackerFault fault) {
  return fault == TrackerFault::Unreachable || fault == TrackerFault::Timeout ||
         fault == TrackerFault::Disconnected || fault == TrackerFault::Protocol;
}

struct TrackerError {
  TrackerFault fault;
  std::string detail;  ///< one sentence for the operator, with the device's own code where there is one
};

struct TrackerIdentity {
  std::string model;
  std::string serial;
  std::string firmware;
};

/// One stationary measurement of a reflector's centre. mm, tracker frame, right-handed Cartesian.
struct SmrPoint {
  Eigen::Vector3d p_WS_mm{0, 0, 0};
  Eigen::Vector3d std_mm{0, 0, 0};  ///< spread of the averaged readings; large = the arm had not settled
  std::optional<MeasuredOrientation> orientation;  ///< of a 6-D target
  double temperature_c = 0;
  double pressure_mbar = 0;
  double humidity_percent = 0;
};

/// A laser tracker that follows one reflector.
///
/// Every call takes a deadline, can be cancelled (then it throws operation_aborted), and leaves the object
/// usable. A failed point is always an error, never a number. Calls come from one strand, one at a time.
class Tracker {
 public:
  virtual ~Tracker() = default;
  /// Connects, writes every setting that the coordinates depend on, and initialises.
  virtual boost::asio::awaitable<std::expected<TrackerIdentity, TrackerError>> connect(
      TimePoint deadline) = 0;
  /// Points at `p_W_mm` and searches for a reflector within `search_radius_mm`; returns when it is locked, in
  /// face 1.
  virtual boost::asio::awaitable<std::expected<void, TrackerError>> aim(Eigen::Vector3d p_W_mm,
                                                                        double search_radius_mm,
                                                                        TimePoint deadline) = 0;
  virtual boost::asio::awaitable<std::expected<SmrPoint, TrackerError>> measure(TimePoint deadline) = 0;
  /// How long each measurement from the next one on averages; at first as the tracker was made to.
  virtual void average_over(Duration time) = 0;
  /// Comes to the same reflector from the other face, where the instrument's errors of aim are opposite, and
  /// locks it again.
  virtual boost::asio::awaitable<std::expected<void, TrackerError>> turn_over(TimePoint deadline) = 0;
  /// Whether it is still there and could measure.
  virtual boost::asio::awaitable<std::expected<void, TrackerError>> check(TimePoint deadline) = 0;
  virtual void disconnect() noexcept = 0;
};

}  // namespace truepose::drivers
