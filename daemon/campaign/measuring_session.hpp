#pragma once

#include <boost/asio/awaitable.hpp>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "core/plan/pose_supply.hpp"
#include "daemon/campaign/arm_motion.hpp"
#include "daemon/campaign/campaign_observer.hpp"
#include "daemon/campaign/campaign_result.hpp"
#include "daemon/campaign/cell_devices.hpp"
#include "daemon/campaign/corrected_points.hpp"
#include "daemon/campaign/reflector_search.hpp"
#include "daemon/threads/signal.hpp"
#include "daemon/threads/worker.hpp"

namespace truepose::daemon {

/// What is measured in place of a pose that failed.
enum class Replacement {
  None,
  Informative,  ///< the pose that tells most beside those that are left
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
  JointVector q_from;  ///< from which the arm comes to it in place of that; empty: no matter whence
  int readings = 1;    ///< of the tracker, of which the point is the mean
};

/// The side from which each joint comes to a target; 0: no matter which.
std::vector<std::int8_t> approach_direction(const MeasuringTarget& target, const RobotModel& robot);

/// What every campaign does: comes to one pose after the other by a clear way, measures it, tries again,
/// recovers lost devices, keeps each point in the journal before the arm moves on, and says how far it is. A
/// pose ends as a point or as a skipped pose with its reason.
class MeasuringSession {
 public:
  template <typename T>
  using Outcome = CampaignOutcome<T>;

  /// What is referred to outlives the session.
  MeasuringSession(const config::CellConfig& config, CampaignDevices devices, CampaignJournal& journal,
                   CampaignObserver& observer, RunJob run_compute);

  /// Connects the devices, begins the journal, and sees by small motions that the arm is the configured one.
  Outcome<void> connect();
  /// Ends the journal, with the result where there is no error.
  boost::asio::awaitable<StoreResult<void>> end(std::optional<CampaignError> error);

  /// Chooses poses and from then on knows ways and substitutes. The options' start, and what only
  /// their comparisons need, are set here.
  Outcome<void> plan(CalibratedCell cell, PlanOptions options, Reflectors reflectors = Reflectors::First);
  const MeasurementPlan& planned() const { return poses_->plan(); }
  /// The next pose of the campaign.
  MeasuringTarget new_target(PointPurpose purpose, const JointVector& q,
                             Replacement replacement = Replacement::None);

  /// The same pose once more.
  MeasuringTarget again(MeasuringTarget target);

  /// Says where the reflector is to be looked for from now on.
  /// @param reach  by which the configured search radius and gate are multiplied
  void expect(CalibratedCell cell, double reach = 1);
  const CalibratedCell& expected() const { return search_.expected(); }

  /// Drives there without measuring; a failure is dealt with, not repeated.
  Outcome<void> visit(JointVector q);
  /// @return the point, of the first reflector that was measured, or nothing where the pose was skipped
  Outcome<std::optional<StoredPoint>> measure(MeasuringTarget target);
  /// Measures all, and substitutes of those that fail. Waits where the campaign is paused.
  /// @param after_each  is run after each pose that was not replaced
  /// @return the targets that were measured, or have failed without a substitute
  Outcome<std::vector<MeasuringTarget>> measure_all(std::vector<MeasuringTarget> targets,
                                                    std::function<Outcome<void>()> after_each = {});
  /// Measures a reflector that stands beside the arm. @return nothing where it was not seen, which is told
  Outcome<std::optional<StoredPoint>> measure_beside(int number, std::string name, Eigen::Vector3d p_W_mm,
                                                     double search_mm);
  /// Of a pose, or of what is measured like one.
  int next_number() { return next_number_++; }
  Outcome<void> skip(MeasuringTarget target, int attempts, std::string reason);

  /// What the job returns, which may take long.
  template <typename Job>
  boost::asio::awaitable<std::invoke_result_t<Job>> compute(Job job) {
    return result_of(run_compute_, std::move(job));
  }
  void report_trouble(const std::string& sentence) { observer_.on_trouble(sentence); }
  void enter(CampaignPhase phase);
  /// @param poses  fewer than none where some turn out not to be needed
  void add_to_total(int poses) { progress_.total += poses; }
  /// Takes effect before the next pose.
  void pause();
  void resume();
  /// The arm may have moved.
  bool has_begun() const { return begun_; }
  CellDevices::Outcome<void> stop_arm() { return devices_.stop(); }

  const config::CellConfig& config() const { return config_; }
  drivers::Clock& clock() const { return clock_; }
  CampaignProgress progress() const;
  CampaignResult& result() { return *result_; }
  /// What there is so far to identify and to validate from.
  MeasurementData data() const { return campaign_data(result_->points, config_); }
  /// All points so far, with what nests and faces tell.
  CorrectedPoints corrected() const { return corrected_points(result_->points, config_); }
  std::shared_ptr<const CampaignResult> shared_result() const { return result_; }

 private:
  Outcome<void> prove_arm();
  Outcome<std::optional<MeasuringTarget>> substitute(MeasuringTarget failed);
  using Points = std::vector<StoredPoint>;
  /// @return at least one of a reflector, each with its point in face 1 behind it where it was seen in both
  CellDevices::Outcome<Points> attempt(MeasuringTarget target);
  CellDevices::Outcome<StoredPoint> attempt_beside(CellDevices::Sight sight);
  /// @return the first of them
  Outcome<StoredPoint> keep(Points points);
  /// On the disk first: what the arm moves on from is never lost.
  Outcome<StoredPoint> store(StoredPoint point);
  /// Writes until the journal has it. Where there is no room the campaign pauses, and what is to be written
  /// waits until somebody has made some and resumes it.
  template <typename T>
  Outcome<T> journalled(std::function<boost::asio::awaitable<StoreResult<T>>()> write);
  Outcome<void> recover(DeviceError error);
  boost::asio::awaitable<void> wait_while_paused();
  /// After the last attempt at a pose, which failed by `error`: pauses where so many in a row were lost.
  /// @return whether it did, and the pose is to be tried again once somebody has resumed
  bool pause_for_losses(const MeasuringTarget& target, const DeviceError& error);
  void count_pose_time();
  std::optional<double> time_left_s() const;
  void tell_progress() const { observer_.on_progress(progress()); }
  void count_error(double deviation_mm);

  const config::CellConfig& config_;
  CellDevices devices_;
  drivers::Clock& clock_;
  CampaignJournal& journal_;
  CampaignObserver& observer_;
  RunJob run_compute_;
  ArmMotion motion_;
  ReflectorSearch search_;
  std::shared_ptr<CampaignResult> result_ = std::make_shared<CampaignResult>();
  bool begun_ = false;  ///< in the journal

  CampaignProgress progress_;
  double error_sum_mm_ = 0;  ///< of this phase, since there is a good prediction
  int error_count_ = 0;
  std::optional<TimePoint> pose_begun_;  ///< when the pose under way was, or the last one ended
  std::vector<double> pose_times_s_;

  std::shared_ptr<PoseSupply> poses_;
  int next_number_ = 1;  ///< of a pose
  int substitutes_ = 0;
  int lost_in_row_ = 0;  ///< poses that were tried for the last time and failed
  int last_lost_ = 0;    ///< the last of them
  bool paused_ = false;
  Signal resumed_;
};

}  // namespace truepose::daemon
