#pragma once

#include <boost/asio/awaitable.hpp>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/compensate/tracker_loop.hpp"
#include "core/identify/calibrate.hpp"
#include "core/judge/drift_check.hpp"
#include "core/judge/iso9283.hpp"
#include "core/judge/test_cube.hpp"
#include "daemon/campaign/cell_devices.hpp"
#include "daemon/store/store.hpp"
#include "proto/record/iso9283_document.hpp"

namespace truepose::daemon {

/// What a campaign is for.
enum class CampaignKind {
  Calibration,
  DriftCheck,  ///< whether the active model is still right, by a few poses
  Targets,     ///< joints at which the arm stands at given targets, by the tracker in the loop
  Iso9283,     ///< pose accuracy and repeatability
};

/// The name on the wire and in the store: "calibration", "drift", "targets", "iso9283".
std::string_view kind_name(CampaignKind kind);

/// What the tracker loop came to at one target.
struct TargetOutcome {
  JointVector q_target;  ///< joints of the nominal arm there
  JointVector q;         ///< found; empty where it was never measured
  std::vector<double> errors_mm;
  double averaged_error_mm = 0;
  bool reached = false;
  std::string reason;  ///< why it was not reached; empty where it was
};

struct TargetsResult {
  TrackerLoopOptions loop;
  int readings = 1;
  std::vector<TargetOutcome> targets;
};

/// One of the poses of a cycle, in which some are come to from several directions.
struct Iso9283Stop {
  std::size_t point = 0;  ///< 0 is P1
  std::string direction;  ///< "+x": upwards along x of the base; empty: from the pose before
};

/// An ISO 9283 test, its attained poses brought into the robot's base.
struct Iso9283Test {
  record::Iso9283Frame frame = record::Iso9283Frame::Model;
  bool compensated = true;
  TestCube cube;
  std::vector<Iso9283Stop> stops;  ///< of a cycle, in their order
  std::vector<TestPoint> points;   ///< P1 to P5
  Iso9283Result result;
};

struct CampaignResult {
  CampaignKind kind = CampaignKind::Calibration;
  Identities identities;
  // Of a drift check:
  std::optional<DriftReference> drift_reference;
  std::optional<DriftCheck> drift;
  std::optional<TargetsResult> targets;
  std::optional<Iso9283Test> iso9283;
  // Of a calibration:
  Calibration calibration;
  MeasurementNoise noise;                             ///< of a point about the calibrated model
  double elapsed_s = 0;                               ///< time that the identification took
  MeasurementData data;                               ///< what was identified and validated from
  std::optional<ErrorStatistics> remeasured;          ///< validation poses reached with compensated joints
  std::vector<Eigen::Vector3d> remeasured_errors_mm;  ///< measured minus asked for, tracker frame
  /// Distances of the reference pose from where it was measured first, in the order of measuring.
  std::vector<double> reference_drift_mm;
  std::vector<StoredPoint> points;
  std::vector<SkippedPose> skipped;
  /// The calibrated arm is nearer to the validation points than the nominal one: it may be activated.
  bool improves = false;
  /// What contradicts the calibration, one sentence each: it is not activated without somebody who decides
  /// so.
  std::vector<std::string> doubts;
};

enum class CampaignFault { Device, WrongArm, Planning, Store, Calibration, Aborted, Internal };

struct CampaignError {
  CampaignFault fault;
  std::string detail;  ///< one sentence for the operator
};

/// What a step of a campaign comes to.
template <typename T>
using CampaignOutcome = boost::asio::awaitable<std::expected<T, CampaignError>>;

}  // namespace truepose::daemon
