#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/steady_timer.hpp>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/cell_config.hpp"
#include "core/calibration/calibrate.hpp"
#include "core/evaluation/drift_check.hpp"
#include "core/planning/pose_supply.hpp"
#include "daemon/campaign/cell_devices.hpp"
#include "daemon/store/store.hpp"

namespace truepose::daemon {

/// What a campaign is for.
enum class CampaignKind {
  Calibration,
  DriftCheck,  ///< whether the active model is still right, by a few poses
};

enum class CampaignPhase { Connect, Plan, WarmUp, Identify, Validate, Compute, Remeasure, Finish };

/// The name on the wire: "warming_up", "remeasuring".
std::string_view phase_name(CampaignPhase phase);

struct CampaignProgress {
  CampaignPhase phase = CampaignPhase::Connect;
  int done = 0;   ///< poses measured or skipped
  int total = 0;  ///< poses planned, those to measure again with compensated joints and substitutes included
  int skipped = 0;
  std::optional<double>
      error_mm;  ///< mean distance from the prediction in this phase, once there is a good one
  std::optional<double> time_left_s;  ///< from the time that the poses so far took
};

struct CampaignResult {
  CampaignKind kind = CampaignKind::Calibration;
  Identities identities;
  // Of a drift check:
  std::optional<DriftReference> drift_reference;
  std::optional<DriftCheck> drift;
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
};

enum class CampaignFault { Device, WrongArm, Planning, Store, Calibration, Aborted, Internal };

struct CampaignError {
  CampaignFault fault;
  std::string detail;  ///< one sentence for the operator
};

/// Keeps one campaign. What returned without an error is on the disk. It stamps times and knows the
/// campaign's id.
class CampaignJournal {
 public:
  virtual ~CampaignJournal() = default;
  /// Called once, when the devices are known (or could not be reached: then their names are empty).
  virtual boost::asio::awaitable<StoreResult<void>> begin(Identities identities) = 0;
  virtual boost::asio::awaitable<StoreResult<void>> add_point(StoredPoint point) = 0;
  virtual boost::asio::awaitable<StoreResult<void>> add_skipped(SkippedPose skipped) = 0;
  /// @param result  of a campaign that is done; null otherwise
  virtual boost::asio::awaitable<StoreResult<void>> end(std::shared_ptr<const CampaignResult> result,
                                                        std::optional<CampaignError> error) = 0;
};

/// Who watches a campaign. Called on its strand; returns soon.
class CampaignObserver {
 public:
  virtual ~CampaignObserver() = default;
  virtual void on_progress(const CampaignProgress& progress) = 0;
  /// @param deviation_mm  measured minus predicted, its length
  virtual void on_point(const StoredPoint& point, double deviation_mm, const CampaignProgress& progress) = 0;
  virtual void on_skipped(const SkippedPose& skipped, const CampaignProgress& progress) = 0;
  /// A failed attempt, a lost device, a robot that is not ready: what happened and what is done about it.
  virtual void on_trouble(const std::string& sentence) = 0;
};

/// Runs a job where it may take long and returns when it is done: a pool of threads, or in place in tests.
using RunCompute = std::function<boost::asio::awaitable<void>(std::function<void()>)>;

/// One calibration campaign, from connecting the devices to the measured proof that compensation works.
///
/// The poses are numbered: those planned to identify, those planned to validate, then what comes up on the
/// way (measurements of the reference pose, substitutes of poses that failed), then the validation poses
/// again with compensated joints. Each ends as a point in the journal, before the arm moves on, or as a
/// skipped pose with its reason.
class Campaign {
 public:
  /// What is referred to outlives run().
  ///
  /// @param drift_reference  the active model, for a drift check; without it a calibration
  Campaign(config::CellConfig config, CampaignDevices devices, CampaignJournal& journal,
           CampaignObserver& observer, RunCompute run_compute,
           std::optional<DriftReference> drift_reference = {});

  /// Runs the whole campaign, once. It ends in the journal in every case. End it early by abort(), not by
  /// cancelling.
  boost::asio::awaitable<std::expected<std::shared_ptr<const CampaignResult>, CampaignError>> run();

  /// Takes effect before the next pose.
  void pause();
  void resume();
  /// Stops the arm. run() then returns Aborted with this reason.
  void abort(std::string reason);

  const CampaignProgress& progress() const { return progress_; }

 private:
  template <typename T>
  using Outcome = boost::asio::awaitable<std::expected<T, CampaignError>>;

  /// One target of the plan.
  struct Target {
    int pose = 0;
    PointPurpose purpose = PointPurpose::Identify;
    JointVector q_target;
    JointVector q_commanded;
  };

  Outcome<void> steps();
  Outcome<void> calibration_steps();
  Outcome<void> drift_steps();
  CalibratedCell planning_cell() const;
  Outcome<void> connect();
  Outcome<void> plan();
  void add_reference(const JointVector& q);
  Outcome<void> warm_up();
  Outcome<void> measure_all(CampaignPhase phase, std::vector<Target> targets);
  /// @return whether there is a point
  Outcome<bool> measure_or_skip(Target target);
  Outcome<std::optional<Target>> substitute(Target failed);
  boost::asio::awaitable<std::expected<JointVector, DeviceError>> drive(JointVector q);
  boost::asio::awaitable<std::expected<JointVector, DeviceError>> arrive(Target target);
  boost::asio::awaitable<std::expected<StoredPoint, DeviceError>> attempt(Target target);
  Outcome<void> keep(StoredPoint point);
  void note_reference(const StoredPoint& point);
  Outcome<void> skip(Target target, int attempts, std::string reason);
  Outcome<void> fit_placement();
  Outcome<void> identify();
  Outcome<void> judge_drift();
  Outcome<std::vector<Target>> compensate();
  void judge_remeasured();
  boost::asio::awaitable<void> wait_while_paused();
  boost::asio::awaitable<StoreResult<void>> end_in_journal(std::optional<CampaignError> error);
  Outcome<void> recover(DeviceError error);

  void enter(CampaignPhase phase);
  void count_pose();
  void count_error(double deviation_mm);

  config::CellConfig config_;
  CellDevices devices_;
  drivers::Clock& clock_;
  CampaignJournal& journal_;
  CampaignObserver& observer_;
  RunCompute run_compute_;

  CampaignProgress progress_;
  double error_sum_mm_ = 0;  ///< of this phase, since there is a good prediction
  int error_count_ = 0;
  std::optional<TimePoint> first_pose_;  ///< when the first pose was begun
  std::shared_ptr<PoseSupply> poses_;
  int next_number_ = 0;  ///< of a pose
  int substitutes_ = 0;
  std::vector<std::int8_t> direction_;           ///< in which each joint last moved
  std::optional<Eigen::Vector3d> reference_mm_;  ///< the reference pose where it was measured first
  std::vector<Target> identify_;
  std::vector<Target> validate_;
  CalibratedCell expected_;  ///< where the reflector is looked for
  bool placement_known_ = false;
  std::shared_ptr<CampaignResult> result_;
  bool begun_ = false;

  bool paused_ = false;
  std::unique_ptr<boost::asio::steady_timer> resumed_;
  bool aborting_ = false;
  std::string abort_reason_;
  boost::asio::cancellation_signal cancel_;
};

}  // namespace truepose::daemon
