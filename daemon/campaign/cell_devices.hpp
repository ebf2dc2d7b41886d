#pragma once

#include <boost/asio/awaitable.hpp>
#include <expected>
#include <functional>
#include <optional>
#include <string>

#include "config/cell_config.hpp"
#include "daemon/campaign/arm_check.hpp"
#include "daemon/campaign/device_error.hpp"
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

/// A driver's error with its device, its remedy and its way out.
DeviceError device_error(const drivers::RobotError& error);
DeviceError device_error(const drivers::TrackerError& error, const config::TrackerConfig& tracker);

/// Which devices a campaign needs, in addition to the controller that reports the joint positions.
struct CampaignNeeds {
  bool moving_arm = true;  ///< else it stands, or an operator jogs it
  bool tracker = true;
};

/// When an arm's poses are compared with its controller's.
enum class ArmProof {
  AsItStands,
  ByMotion,  ///< prove_arm() will: one that leaves open which joint is wrong is let pass
};

/// The robot and the tracker of a cell with the deadlines, checks and patience that using them together
/// needs.
class CellDevices {
 public:
  using OnTrouble = std::function<void(const std::string&)>;
  using OnWaiting = std::function<void(CellDevice, const std::string& reason)>;

  /// @param on_trouble  is called with every failure that is being handled
  /// @param on_waiting  is called with the device that is waited for and the reason; without a reason once
  /// the device answers
  CellDevices(const config::CellConfig& config, CampaignDevices devices, OnTrouble on_trouble,
              OnWaiting on_waiting = {});

  template <typename T>
  using Outcome = boost::asio::awaitable<std::expected<T, DeviceError>>;

  /// Reconnects both, with one attempt, and refuses an arm that is not the configured one.
  /// @param with_tracker  else it stays as it is, and its identity is empty
  Outcome<Identities> connect(ArmProof proof = ArmProof::AsItStands, bool with_tracker = true);

  /// Moves every joint alone, by a degree and back, and compares what the controller says
  /// of its axes and its flange with ours: every sign and every zero shows before the first real motion.
  /// Fails with WrongArm, and the joint, as soon as that is known.
  Outcome<void> prove_arm();

  /// Does what a failure asks for, however long it takes: reconnects, tried every second, or waits until the
  /// robot may move. Fails with WrongArm alone.
  Outcome<void> recover(DeviceError lost);
  /// Connects what is not connected. @param robot, tracker  whether it is needed and is not
  Outcome<void> connect_missing(bool robot, bool tracker);

  /// The actual joint positions.
  Outcome<JointVector> position();

  /// Position of an arm that an operator jogs: in any operating mode, by the controller's state server alone.
  /// Fails with Retry while it moves.
  Outcome<JointVector> standstill();
  /// Whether an arm at q stands where another time it stood at `before`: no operator jogs it back so
  /// precisely.
  static bool has_stayed(const JointVector& q, const JointVector& before);

  /// Moves, and compares what the controller says of its axes and its flange there with ours.
  /// @return the actual joint positions at the end
  Outcome<JointVector> move(JointVector q);

  /// Where a reflector is looked for, and how it is measured.
  struct MeasureRequest {
    Eigen::Vector3d p_W_mm;
    double search_mm = 0;
    double gate_mm = 0;     ///< farther from `p_W_mm` is another reflector: an error
    int readings = 1;       ///< one after the other; the point is their mean, see mean_reading()
    bool two_face = false;  ///< in both faces; the point is their mean
  };
  struct MeasureResult {
    drivers::SmrPoint point;
    std::optional<drivers::SmrPoint> face1;  ///< what face 1 alone saw, where it was measured in both
  };
  /// A reading that by the tracker's own account scatters by more than tracker.max_std_mm is taken again for
  /// longer, and an error where it still does.
  Outcome<MeasureResult> measure(MeasureRequest request);

  /// Brakes the arm, as far as it can be reached.
  Outcome<void> stop();

  void disconnect() noexcept;

 private:
  Outcome<drivers::RobotIdentity> connect_robot(ArmProof proof = ArmProof::AsItStands);
  Outcome<drivers::RobotState> ready_state();
  Outcome<JointVector> drive(JointVector q);
  Outcome<ControllerPose> pose_at(JointVector q);
  Outcome<drivers::TrackerIdentity> connect_tracker();
  Outcome<void> wait_for_robot();
  /// The mean of so many steady readings.
  Outcome<drivers::SmrPoint> readings(int count);
  Outcome<drivers::SmrPoint> steady_reading();
  /// @param times  so many times the usual time
  Outcome<drivers::SmrPoint> reading(int times);
  Outcome<void> turn_over();
  Outcome<void> apply_remedy(Remedy remedy);
  boost::asio::awaitable<DeviceError> explained(DeviceError error);
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
