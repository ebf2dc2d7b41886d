#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/frame_file.hpp"
#include "core/calibrate/calibrate.hpp"
#include "core/change/drift_check.hpp"
#include "core/change/drift_update.hpp"
#include "core/compensate/tracker_loop.hpp"
#include "core/frames/frame_readings.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "core/quality/iso9283.hpp"
#include "core/quality/test_cube.hpp"
#include "daemon/campaign/cell_devices.hpp"
#include "daemon/store/campaign_plan.hpp"
#include "daemon/store/store.hpp"
#include "proto/record/iso9283_document.hpp"

namespace truepose::daemon {

// What a campaign is to do, kind by kind.

/// Identify the arm.
struct CalibrationOrder {};

/// Find the joints at which the arm stands at given targets, by the tracker in the loop.
struct TargetsOrder {
  CalibratedCell cell;       ///< the active model
  std::string model_id;      ///< by which the store has it
  std::string model_serial;  ///< of its arm
  /// Joints at which the nominal arm would be at each target; none: validation poses of a plan, as many as
  /// configured.
  std::vector<JointVector> targets;
  TrackerLoopOptions loop;
  int readings = 3;  ///< of the tracker in each round
};

/// Find pose accuracy and repeatability.
struct Iso9283Order {
  std::optional<CalibratedCell> cell;  ///< the active model, where there is one
  std::string model_serial;            ///< of its arm
  bool compensate = true;              ///< by the model, which must then be given
  int cycles = kIso9283Cycles;
  bool variation = false;  ///< come to P1, P2 and P4 along the three axes of the base too
};

/// Ask whether the active model is still right.
struct DriftOrder {
  DriftReference reference;
  bool update = false;  ///< bring it up to date by the same points
  ModelRecord model;    ///< that it is about
};

/// A point of a tool, where a reflector sits that the tracker reads.
struct ToolPoint {
  FramePoint point;
  Eigen::Vector3d p_F_mm{0, 0, 0};  ///< where it is, roughly, in the flange frame
};

/// Find where a tool is on the flange, with the calibrated arm.
struct ToolOrder {
  int number = 1;            ///< of TOOL_DATA
  MeasuringCell by;          ///< the active model
  std::string model_id;      ///< by which the store has it
  std::string model_serial;  ///< of its arm
  std::vector<ToolPoint> points{{{kOrigin, std::nullopt}, {0, 0, 0}}};
  /// Reflectors sit at all points; else one is put from each to the next by hand.
  bool together = false;
  std::optional<Eigen::Vector3d> facing_F;  ///< direction of their openings; none: of the cell's reflector
  /// Orientation, in place of a 6-D target's; none: that, or the flange's where the TCP alone is measured.
  std::optional<Eigen::Matrix3d> R_given{};
  int poses = 10;  ///< in which each point is measured
  std::optional<Eigen::Vector3d>
      reach_F_mm;       ///< where the TCP is known to be, roughly: so far the tool reaches
  std::string assumed;  ///< where the points were taken to be, and why, as a sentence
};

/// A point of a fixture.
struct FixturePoint {
  FramePoint point;
  Eigen::Vector3d p_B_mm{0, 0, 0};  ///< where it is, roughly, in the robot base; for the tracker
};

/// The tool whose TCP touches a fixture's points.
struct TouchOrder {
  config::ToolFile tool;
  MeasuredFrame measured;  ///< where its readings have it under the order's model
};

/// Find where a work frame is in the robot base: by a reflector that is put to its points by hand, while the
/// arm stands still, or by the TCP of a tool that is jogged to them.
struct BaseOrder {
  int number = 1;              ///< of BASE_DATA
  MeasuringCell by;            ///< the active model
  std::string model_id{};      ///< by which the store has it
  std::string model_serial{};  ///< of its arm
  std::string model_made{};    ///< when that was, RFC 3339
  std::vector<FixturePoint> points;
  int readings = 3;                   ///< of each point, or touches
  std::optional<TouchOrder> touch{};  ///< none: the tracker reads them
};

using CampaignOrder =
    std::variant<CalibrationOrder, DriftOrder, TargetsOrder, Iso9283Order, ToolOrder, BaseOrder>;

/// Serial number of the arm by whose model a campaign works; empty: it works by none.
std::string model_serial(const CampaignOrder& order);

// What it came to.

/// A validation pose that was reached again with compensated joints.
struct RemeasuredPoint {
  StoredPoint point;
  Eigen::Vector3d error_mm;  ///< measured minus asked for, tracker frame
};

struct CalibrationResult {
  Calibration calibration;
  MeasurementNoise noise;  ///< of a point about the calibrated model
  std::vector<double> validation_distances2;
  double elapsed_s = 0;                       ///< time that the identification took
  std::optional<ErrorStatistics> remeasured;  ///< of the points measured again
  std::vector<RemeasuredPoint> remeasured_points;
  /// Distances of the reference pose from where it was measured first, in the order of measuring.
  std::vector<double> reference_drift_mm;
  /// If it failed, the model is not activated without a decision of an operator.
  CalibrationVerdict verdict;
};

struct DriftResult {
  DriftOrder order;
  DriftCheck check;
  std::optional<DriftUpdate> update;  ///< where it was ordered

  /// Whether there is a new model, against which nothing speaks.
  bool updated() const { return update && update->doubts.empty(); }
};

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

/// Where a tool is.
struct ToolResult {
  ToolOrder order;
  FrameReadings data;
  MeasuredFrame frame;
};

/// Where a work frame is.
struct BaseResult {
  BaseOrder order;
  FrameReadings data;
  MeasuredFrame frame;
};

/// What a campaign of each kind comes to, in the order of the orders.
using CampaignFindings =
    std::variant<CalibrationResult, DriftResult, TargetsResult, Iso9283Test, ToolResult, BaseResult>;

/// The names of the kinds on the wire and in the store.
inline constexpr std::array<std::string_view, 6> kCampaignKinds{"calibration", "drift", "targets",
                                                                "iso9283",     "tool",  "base"};

/// @param of  an order, or what came of it
template <typename... Kinds>
std::string_view kind_name(const std::variant<Kinds...>& of) {
  static_assert(sizeof...(Kinds) == kCampaignKinds.size());
  return kCampaignKinds[of.index()];
}

struct CampaignResult {
  Identities identities;
  std::vector<StoredPoint> points;
  std::vector<SkippedPose> skipped;
  std::vector<Resumption> resumptions;  ///< after each of its interruptions
  CampaignFindings findings;

  template <typename Kind>
  Kind& as() {
    return std::get<Kind>(findings);
  }
  template <typename Kind>
  const Kind& as() const {
    return std::get<Kind>(findings);
  }
};

/// Whether a model is made from it, or judged by it.
inline bool shows_arm(const StoredPoint& point) {
  return point.purpose == PointPurpose::Identify || point.purpose == PointPurpose::Validate;
}
/// The points to identify and to validate from, in the order of measuring. Its reflectors are those that were
/// measured.
/// @param smr  the reflector that comes first, where it was measured
MeasurementData measurement_data(const std::vector<StoredPoint>& points, const std::string& smr);
/// The readings of the points of a tool or a fixture. Their rows count from 1.
/// @param points_of_frame  in their order, of which others are no readings; empty: all that were measured
FrameReadings frame_readings(const std::vector<StoredPoint>& points,
                             std::vector<FramePoint> points_of_frame = {});
/// The same of a fixture: the arm had no part in what the tracker read there.
FrameReadings readings_of_base(const std::vector<StoredPoint>& points,
                               std::vector<FramePoint> points_of_frame = {});
/// Those that a check of drift judges, numbered from 1 as the rows of a file.
std::vector<Measurement> numbered_points(const std::vector<StoredPoint>& points);

enum class CampaignFault { Device, WrongArm, Planning, Store, Calibration, Aborted, Internal };

struct CampaignError {
  CampaignFault fault;
  std::string detail;        ///< one sentence for the operator
  bool interrupted = false;  ///< it may continue later
  std::string what_to_do{};  ///< about the cause; empty: the detail ends with it
};

inline CampaignError store_failed(const StoreError& error) { return {CampaignFault::Store, error.detail}; }

/// What a step of a campaign comes to.
template <typename T>
using CampaignOutcome = boost::asio::awaitable<std::expected<T, CampaignError>>;
/// The same of a step without a result, once it has ended.
using Done = std::expected<void, CampaignError>;

}  // namespace truepose::daemon
