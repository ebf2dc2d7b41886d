#pragma once

#include <array>
#include <boost/json/fwd.hpp>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "core/calibrate/calibration.hpp"
#include "core/named.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "core/quality/path_accuracy.hpp"
#include "proto/record/arm_document.hpp"
#include "proto/record/campaign_records.hpp"
#include "proto/record/layout.hpp"
#include "proto/record/transfer.hpp"

/// The document of one calibration, mm and rad: what `truepose calibrate --json` prints, what the daemon
/// keeps of a campaign, and what reports are made of. Its schema is proto/control/report.schema.json.
namespace truepose::record {

/// What one of several tracker stations saw.
struct Station {
  std::string name;
  BasePose base;  ///< of the robot in the frame of the station's tracker
  StageErrors identify;
  std::optional<StageErrors> validate;
};

/// One measurement, in the words of a measurement file, and its errors through the stages: predicted minus
/// measured, mm, tracker frame (of several stations, the first one's).
/// How a 6-D target was turned at a point: KUKA's angles of its axes in the tracker frame, deg.
struct TurnedTarget {
  double a = 0, b = 0, c = 0;
  double sigma = 0;  ///< of a turn about each axis
};

/// How a 6-D target is mounted on the flange: R_FT = Rz(rz) Ry(ry) Rx(rx), rad.
struct MountedTarget {
  std::string smr;
  Eigen::Vector3d rxyz_rad{0, 0, 0};
  double sigma_rad = 0;  ///< of a turn about each axis, root mean square
};

struct Point {
  std::string station;  ///< empty where there is one
  int pose = 0;         ///< from 1; points with the same joints have the same
  PoseSet set = PoseSet::Identify;
  std::string smr;
  std::vector<double> joints;               ///< deg (mm for a prismatic joint)
  std::optional<Eigen::Vector3d> position;  ///< mm, tracker frame; likewise
  std::optional<double> sigma;              ///< mm
  std::optional<double> excess;  ///< mm, beyond the stated noise; where it is known to be less steady
  std::optional<TurnedTarget> orientation;
  std::vector<std::int8_t> direction;
  std::optional<LinkMass> payload;
  std::string time;
  Eigen::Vector3d before{0, 0, 0}, geometric{0, 0, 0}, after{0, 0, 0};
};

struct Rejected {
  std::size_t point = 0;  ///< from 1, as `row` and `pose`; 0: not known
  int row = 0, pose = 0;
  std::string smr, station;  ///< no station where there is one
  double residual_mm = 0, sigmas = 0;
  double orientation_error_rad = 0;  ///< where the turn of its target contradicts the others
};

struct Observability {
  ObservabilityIndices indices;
  std::vector<std::string> not_identifiable, weakly_identifiable;  ///< sentences
};

/// How far the link errors were taken as small before they were measured.
struct UsedPrior {
  bool used = false;
  PriorScale scale;
};

struct Iterations {
  int coarse = 0, fine = 0;
};

/// Standard deviations of a stage's errors over the runs of a validation, mm.
struct StageSpread {
  double mean = 0, max = 0, rms = 0;
};
enum class Runs { Splits, Folds };
inline constexpr std::array kRunNames{Named{"splits", Runs::Splits}, Named{"folds", Runs::Folds}};
struct Spread {
  Runs over = Runs::Splits;
  int count = 0;
  StageSpread before, geometric, after;
};

/// From the smallest to the greatest value that was met.
struct Extent {
  double min = 0, max = 0;
};
/// Under which conditions a campaign measured.
struct Conditions {
  std::string started, ended;  ///< RFC 3339
  int poses_measured = 0, poses_skipped = 0;
  std::optional<Extent> temperature_c, pressure_mbar, humidity_percent;
};
/// A validation pose that was reached with compensated joints and measured again.
struct Remeasured {
  int pose = 0;  ///< of `points`
  std::string smr;
  Eigen::Vector3d error{0, 0, 0};
};

/// How the stream of corrections went.
struct Stream {
  std::int64_t cycles = 0, answered = 0, late = 0, wrong_ipoc = 0;
  std::int64_t unconfirmed = 0, sessions = 1;
  double max_step_deg = 0;
  struct Turnaround {
    double p50 = 0, p99 = 0, p999 = 0, max = 0;
  } turnaround_us;  ///< from a datagram's arrival to its reply
};

/// How a production program went under correction: mm, the lag's members where the axes were recorded.
struct Production {
  ProductionPath path;
  PathAccuracy accuracy;
};
void layout(Io& io, Production& x);
Production production_of(ProductionPath path);

/// A production program that a model file judged, without a campaign: `truepose report --path --json` prints
/// it.
struct ProductionDocument {
  std::string robot, model;
  Production production;
};
void layout(Io& io, ProductionDocument& x);

/// What warmth does to the arm, and what knowing it bought.
struct Thermal {
  bool chosen = false;
  double without_rms_mm = 0, rms_mm = 0;  ///< of points as the others predict them, whitened
  double time_constant_s = 0;             ///< of warmth by time; 0: by something else
  double time_constant_poses = 0;         ///< of the warm-up by the order of the poses, if no time is given
  // Where it was chosen:
  std::vector<double> reference_c;  ///< of each joint's drive: of which all else in the document is
  std::vector<double> zero_per_k;   ///< of each joint: deg (mm) per kelvin of its drive
  double expansion_ppm_per_k = 0;   ///< of all lengths
};

/// What the document calls its method. It has one.
enum class Method { TwoStage };
inline constexpr std::array kMethods{Named{"two-stage", Method::TwoStage}};

/// One run of a validation over several splits or folds.
struct Run {
  std::optional<std::uint64_t> seed;  ///< of a split
  std::optional<int> fold;            ///< from 1
  bool converged = false;
  Iterations iterations;
  StageErrors identify, validate;
  int rank = 0;
  double condition = 0;
};

/// What a simulated arm really is.
struct TrueLink {
  double a_mm = 0, alpha_rad = 0, d_mm = 0, theta_rad = 0, beta_rad = 0;
};
struct Truth {
  BasePose base;
  Eigen::Vector3d p_FS_mm{0, 0, 0};
  std::vector<TrueLink> links;
};
void layout(Io& io, Truth& x);

struct CalibrationDocument {
  Method method = Method::TwoStage;
  bool converged = false;
  Iterations iterations;
  double elapsed_s = 0;
  StageErrors identify;
  std::optional<StageErrors> validate;
  int rank = 0;
  std::optional<double> rank_gap;  ///< where a parameter could not be determined
  double condition = 0;
  std::optional<double> sigma0_mm;
  std::optional<DeviationChoice> non_geometric;  ///< without its terms
  std::optional<FieldChoice> field;              ///< without its regressor
  std::optional<Thermal> thermal;                ///< if the points have temperatures of the arm
  std::optional<Observability> observability;
  std::optional<UsedPrior> prior;
  std::optional<Transfer> prediction_uncertainty;  ///< where the covariance is known
  std::vector<Rejected> rejected;
  std::vector<Rejected> validation_outliers;  ///< beyond six sigma, and in the statistics all the same
  std::optional<BasePose> base;               ///< the first station's
  std::vector<Station> stations;              ///< where there are several
  std::vector<Reflector> smr;
  std::vector<MountedTarget> targets;
  std::vector<IdentifiedParameter> parameters;
  std::optional<Arm> arm;  ///< nominal
  std::vector<Point> points;

  // What commands and campaigns add.
  std::optional<CalibrationVerdict> verdict;  ///< none: it was not judged
  std::optional<MeasurementNoise> noise;
  std::optional<Spread> spread;
  std::vector<Run> splits;  ///< each run of a validation in several
  std::vector<Point> fold_points;
  std::string robot, tracker, campaign, model, date;  ///< empty where not known
  ByName<std::string> files, options;
  std::vector<std::string> read_as;  ///< how files were understood that were not in truepose's own form
  std::optional<Conditions> conditions;
  std::optional<std::vector<SkippedPose>> skipped;  ///< none: no campaign measured
  std::vector<Interruption> interruptions;
  std::vector<double> reference_drift_mm;
  std::optional<ErrorStatistics> remeasured;
  std::vector<Remeasured> remeasured_points;
  std::optional<Stream> stream;
  std::optional<Production> production;
  std::optional<Truth> truth;
};

/// Error statistics as every document of ours carries them, mm:
/// {"mean","rms","max","min","std","x":{"mean_abs","rms","max"},"y":{..},"z":{..}}.
void layout(Io& io, ErrorStatistics& x);

/// The errors of one set of points as documents carry them: {"poses","points","before","geometric","after"}.
void layout(Io& io, StageErrors& x);

/// {"color","findings":[{"severity","code","sentence","what_to_do"}]}, the gravest first.
boost::json::object verdict_json(const CalibrationVerdict& verdict);

boost::json::object calibration_document(const CalibrationDocument& document);
/// The same, where the errors of validation are the mean of those of all its splits.
boost::json::object calibration_document_over_splits(const CalibrationDocument& document);

/// The JSON Schema of calibration documents, which is report.schema.json.
boost::json::object calibration_document_schema();

/// Reads such a document. @return it, or one sentence that names the member
std::expected<CalibrationDocument, std::string> read_calibration_document(
    const boost::json::object& document);

}  // namespace truepose::record
