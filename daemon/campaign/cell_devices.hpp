#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <expected>
#include <functional>
#include <string>

#include "config/cell_config.hpp"
#include "drivers/robot.hpp"
#include "drivers/tracker.hpp"

namespace truepose::daemon {

using drivers::Duration;
using drivers::TimePoint;

enum class CellDevice { Controller, Tracker };

struct CampaignDevices {
  drivers::Robot& robot;
  drivers::Tracker& tracker;
  drivers::Clock& clock;
};

struct Identities {
  drivers::RobotIdentity robot;
  drivers::TrackerIdentity tracker;
};

/// What a failure asks for.
enum class Remedy {
  Retry,  ///< the device is fine, the attempt was not
  ReconnectRobot,
  ReconnectTracker,
  WaitForRobot,  ///< connected, but it may not move
  GiveUp,        ///< it was waited for long enough
  WrongArm,      ///< not the configured one: nothing that a repeat would change
};

struct DeviceError {
  Remedy remedy;
  std::string detail;      ///< one sentence for the operator
  bool beam_lost = false;  ///< no reflector was seen, or not to the end
};

/// The controller's own pose of the flange against the nominal arm's: a wrong arm, or a wrong robot file.
std::expected<void, DeviceError> check_arm(const config::RobotConfig& robot,
                                           const drivers::RobotIdentity& identity,
                                           const drivers::RobotState& state);

/// The robot and the tracker of a cell with the deadlines, checks and patience that using them together
/// needs.
class CellDevices {
 public:
  using OnTrouble = std::function<void(const std::string&)>;
  using OnWaiting = std::function<void(CellDevice, const std::string& reason)>;

  /// @param on_trouble  is told of every failure that is being dealt with
  /// @param on_waiting  is told which device is waited for and why, and without a reason that it answers
  CellDevices(const config::CellConfig& config, CampaignDevices devices, OnTrouble on_trouble,
              OnWaiting on_waiting = {});

  template <typename T>
  using Outcome = boost::asio::awaitable<std::expected<T, DeviceError>>;

  /// Connects both anew, tried once, and refuses an arm that is not the configured one.
  Outcome<Identities> connect();

  /// Does what a failure asks for: reconnects with growing pauses, or waits until the robot may move.
  /// Fails with GiveUp when that takes longer than kPatience, or with WrongArm.
  Outcome<void> recover(DeviceError lost);

  /// The actual joint positions.
  Outcome<JointVector> position();

  /// @return the actual joint positions at the end
  Outcome<JointVector> move(JointVector q);

  /// Aims at `p_W_mm` and measures what is found there. Farther from it than `gate_mm` is a wrong reflector:
  /// an error, and so is a reading that by the tracker's own account scatters by more than kMostScatter times
  /// the configured noise.
  /// @param readings  so many, one after the other; the point is their mean
  Outcome<drivers::SmrPoint> measure(Eigen::Vector3d p_W_mm, double search_radius_mm, double gate_mm,
                                     int readings = 1);

  /// Brakes the arm, as far as it can be reached.
  boost::asio::awaitable<void> stop();

  void disconnect() noexcept;

  /// How long a lost device is waited for.
  static constexpr std::chrono::minutes kPatience{10};

 private:
  Outcome<drivers::RobotIdentity> connect_robot();
  Outcome<drivers::TrackerIdentity> connect_tracker();
  Outcome<void> wait_for_robot();
  void await(CellDevice device, const std::string& reason) const {
    if (on_waiting_) on_waiting_(device, reason);
  }
  /// What the tracker itself says of a point against the noise that the cell states.
  std::expected<void, DeviceError> check_scatter(const drivers::SmrPoint& point) const;

  const config::CellConfig& config_;
  drivers::Robot& robot_;
  drivers::Tracker& tracker_;
  drivers::Clock& clock_;
  OnTrouble on_trouble_;
  OnWaiting on_waiting_;
};

}  // namespace truepose::daemon
