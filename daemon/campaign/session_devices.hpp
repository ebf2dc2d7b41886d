#pragma once

#include <string>
#include <vector>

#include "daemon/campaign/arm_motion.hpp"
#include "daemon/campaign/campaign_run.hpp"
#include "daemon/campaign/cell_devices.hpp"
#include "daemon/campaign/reflector_search.hpp"

namespace truepose::daemon {

/// What is measured in place of a pose that failed.
enum class Replacement {
  None,
  Informative,  ///< the pose with the most information in addition to the remaining ones
  Near,         ///< one close by
};

/// A pose to measure.
struct MeasuringTarget {
  int pose = 0;  ///< its number in the campaign, from 1
  PointPurpose purpose = PointPurpose::Identify;
  JointVector q_target;
  JointVector q_commanded;
  Replacement replacement = Replacement::None;
  double way_rad = 0;  ///< by which every joint comes to it, see approach_way_rad()
  JointVector q_from;  ///< start of the approach in place of way_rad; empty: any
  int readings = 1;    ///< of the tracker, of which the point is the mean
  int replaces = 0;    ///< number of the pose that failed, whose substitute it is; 0: it is none
};

/// The side from which each joint comes to a target; 0: no matter which.
std::vector<std::int8_t> approach_direction(const MeasuringTarget& target, const RobotModel& robot);

/// A fixed reflector near the arm.
struct FixedReflector {
  int number = 0;
  std::string name;
  PointPurpose purpose = PointPurpose::Nest;
};

/// The devices of a campaign: an attempt at a time to come to a pose and read its reflectors, and what has to
/// be done after one that failed.
class SessionDevices {
 public:
  /// @param run  outlives it
  SessionDevices(CampaignRun& run, CampaignDevices devices, RunJob run_compute);

  /// A device that is away for a moment, or hangs up, does not end a campaign. A device that stays away is
  /// reported before the arm has moved.
  CampaignOutcome<Identities> connect(CampaignNeeds needs);
  /// By small motions.
  CampaignOutcome<void> prove_arm();
  /// After a failed attempt: whatever lets the next one succeed. Fails where there is to be no next one.
  CampaignOutcome<void> recover(DeviceError error);

  /// @return at least one point of a reflector, each after what face 1 saw where it was seen in both
  CellDevices::Outcome<std::vector<StoredPoint>> read(MeasuringTarget target);
  /// Does not move the arm; its joints are stored with the point.
  CellDevices::Outcome<StoredPoint> read_fixed(FixedReflector what, CellDevices::MeasureRequest request);
  /// A point of before once more. The place where it should be now is looked at in a wide circle.
  CellDevices::Outcome<StoredPoint> read_again(StoredPoint before, Eigen::Vector3d p_W_mm);

  CellDevices& cell() { return cell_; }
  ArmMotion& motion() { return motion_; }
  ReflectorSearch& search() { return search_; }

 private:
  CellDevices::Outcome<JointVector> reach(MeasuringTarget target);
  StoredPoint point_at(const MeasuringTarget& target, const JointVector& reached,
                       const drivers::SmrPoint& measured, const std::string& smr) const;
  bool in_two_faces(int pose) const;

  CampaignRun& run_;
  CellDevices cell_;
  ArmMotion motion_;
  ReflectorSearch search_;
};

}  // namespace truepose::daemon
