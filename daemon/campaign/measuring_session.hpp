#pragma once

#include <boost/asio/awaitable.hpp>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/cell_config.hpp"
#include "core/plan/pose_supply.hpp"
#include "daemon/campaign/arm_motion.hpp"
#include "daemon/campaign/campaign_run.hpp"
#include "daemon/campaign/cell_devices.hpp"
#include "daemon/campaign/reflector_search.hpp"
#include "daemon/threads/worker.hpp"

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

/// What every campaign does: comes to one pose after the other by a clear way, measures it, tries again,
/// recovers lost devices, keeps each point in the journal before the arm moves on, and says how far it is. A
/// pose ends as a point or as a skipped pose with its reason.
///
/// Of a campaign that was interrupted it takes what was measured or skipped from the past, so that the same
/// steps lead to where it was. Before the first that is not there it sees what has moved meanwhile. Points
/// are given, and places asked for, in the frame in which the tracker stood when the campaign began.
class MeasuringSession : public CampaignRun {
 public:
  /// What is referred to outlives the session.
  /// @param past  of a campaign that was interrupted; null: it begins
  MeasuringSession(const config::CellConfig& config, CampaignDevices devices, CampaignJournal& journal,
                   CampaignObserver& observer, RunJob run_compute,
                   std::shared_ptr<const CampaignPast> past = {});

  /// Begins the journal, connects the devices, and sees by small motions that the arm is the configured one;
  /// of one that is not to be moved, as far as it shows that where it stands.
  CampaignOutcome<void> connect(const CampaignNeeds& needs);
  /// Ends the journal, with the result where there is no error.
  boost::asio::awaitable<StoreResult<void>> end(std::optional<CampaignError> error);

  /// Chooses poses and from then on knows ways and substitutes. The options' start, and what only
  /// their comparisons need, are set here.
  CampaignOutcome<void> plan(CalibratedCell cell, PlanOptions options,
                             Reflectors reflectors = Reflectors::First);
  const MeasurementPlan& planned() const { return poses_->plan(); }
  /// The next pose of the campaign.
  MeasuringTarget new_target(PointPurpose purpose, const JointVector& q,
                             Replacement replacement = Replacement::None);

  /// Keeps in the journal what is to be measured, as is done of each pose at the latest before the arm goes
  /// there.
  CampaignOutcome<void> keep_plan(std::vector<MeasuringTarget> targets);

  /// The same pose once more.
  MeasuringTarget again(MeasuringTarget target);

  /// Says where the reflector is to be looked for from now on.
  /// @param reach  by which the configured search radius and gate are multiplied
  void expect(CalibratedCell cell, double reach = 1);
  const CalibratedCell& expected() const { return search_.expected(); }
  /// Says that an operator moves the one reflector from point to point of the arm, and that it is at this one
  /// now.
  void reflector_is_at(std::size_t place) { search_.look_for_single(place); }
  /// Whether a reflector of this name is on the arm now.
  bool has_reflector(std::string_view name) const { return search_.is_there(name); }
  /// Pauses for an operator action, which the sentence asks for, until the operator resumes. Does nothing if
  /// the next point was measured before an interruption.
  boost::asio::awaitable<void> wait_for_operator(std::string sentence);

  /// Drives there without measuring; a failure is dealt with, not repeated.
  CampaignOutcome<void> visit(JointVector q);
  /// @return the point, of the first reflector that was measured, or nothing where the pose was skipped
  CampaignOutcome<std::optional<StoredPoint>> measure(MeasuringTarget target);
  /// Measures all, and substitutes of those that fail. Waits where the campaign is paused.
  /// @param after_each  is run after each pose that was not replaced
  /// @return the targets that were measured, or have failed without a substitute
  CampaignOutcome<std::vector<MeasuringTarget>> measure_all(
      std::vector<MeasuringTarget> targets, std::function<CampaignOutcome<void>()> after_each = {});
  /// A fixed reflector near the arm.
  struct FixedReflector {
    int number = 0;
    std::string name;
    PointPurpose purpose = PointPurpose::Nest;
  };
  /// Measures it. @return nothing if it was not seen, which is reported
  CampaignOutcome<std::optional<StoredPoint>> measure_fixed(FixedReflector what, Eigen::Vector3d p_W_mm,
                                                            double search_mm);
  /// A point that the arm's TCP is to touch.
  struct Touch {
    int number = 0;
    std::string point;    ///< its name
    std::string request;  ///< what the operator is asked to do, as a sentence
  };
  /// Waits until the operator has jogged the arm there, and keeps its joint positions. Asks again, and says
  /// why, where the arm still moves, has not been moved since the touch before, or cannot be asked.
  CampaignOutcome<void> touch(Touch what);
  /// Of a pose, or of what is measured like one.
  int next_number() { return next_number_++; }
  CampaignOutcome<void> skip(MeasuringTarget target, int attempts, std::string reason);

  /// Whether it continues where it was interrupted.
  bool resumes() const { return past_ != nullptr; }
  /// Whether what was measured is taken for good: nothing speaks against going on.
  bool has_resumed() const { return has_resumed_; }
  /// What is done before it is seen what has moved: the arm has to be as warm as it was.
  void before_resuming(std::function<CampaignOutcome<void>()> act) { before_resuming_ = std::move(act); }
  /// At the end of one that had nothing left to measure.
  CampaignOutcome<void> note_resumption();
  /// Measures a point of before once more. The place where it should be now is looked at in a wide circle.
  /// @return where the tracker sees it now, in its own frame; nothing where it does not
  CampaignOutcome<std::optional<Eigen::Vector3d>> measure_again(StoredPoint before, Eigen::Vector3d p_W_mm);
  /// Keeps the hash of what was identified, or compares it with that of before.
  CampaignOutcome<void> keep_identified(std::string sha256);

  /// The arm may have moved.
  bool has_begun() const { return begun_; }
  CellDevices::Outcome<void> stop_arm() { return devices_.stop(); }

 private:
  CampaignOutcome<void> prove_arm();
  CellDevices::Outcome<Identities> connected_devices(const CampaignNeeds& needs);
  boost::asio::awaitable<StoreResult<void>> begin();
  CampaignOutcome<std::optional<MeasuringTarget>> substitute(MeasuringTarget failed);
  MeasuringTarget new_substitute(const MeasuringTarget& failed, const JointVector& q);
  using Points = std::vector<StoredPoint>;
  /// @return at least one of a reflector, each with its point in face 1 behind it where it was seen in both
  CellDevices::Outcome<Points> attempt(MeasuringTarget target);
  CellDevices::Outcome<StoredPoint> attempt_fixed(CellDevices::MeasureRequest request);
  CellDevices::Outcome<JointVector> jogged_to();
  CellDevices::Outcome<JointVector> reach(MeasuringTarget target);
  StoredPoint point_at(const MeasuringTarget& target, const JointVector& reached,
                       const drivers::SmrPoint& measured, const std::string& smr) const;
  /// @param smr  the reflector that is looked for; it is a nest, or the arm comes to the target first
  CellDevices::Outcome<StoredPoint> attempt_again(MeasuringTarget target, CellDevices::MeasureRequest request,
                                                  std::string smr, bool is_nest);
  bool in_two_faces(int pose) const;
  /// Where the tracker sees now what it saw at p_mm when the campaign began.
  Eigen::Vector3d now(const Eigen::Vector3d& p_mm);

  /// What a step came to before the interruption.
  struct Before {
    std::optional<StoredPoint> point;  ///< none: it was skipped
  };
  std::optional<Before> taken_before(const MeasuringTarget& target);
  std::optional<StoredPoint> measured_before(int number, PointPurpose purpose, std::string_view smr = {});
  /// Error: what was touched is of another order.
  std::expected<bool, CampaignError> touched_before(const Touch& what);
  bool skipped_before(int number);
  /// Why the past does not follow from the plan.
  std::optional<CampaignError> contradiction(const MeasuringTarget& target) const;
  void begin_resumption(const std::string& time);
  CampaignOutcome<void> resume_from_past();
  std::optional<CampaignError> other_arm();
  /// @return the first of them
  CampaignOutcome<StoredPoint> keep(Points points);
  double count_deviation(const StoredPoint& point);
  /// On the disk first: what the arm moves on from is never lost.
  CampaignOutcome<StoredPoint> store(StoredPoint point);
  CampaignOutcome<void> recover(DeviceError error);
  /// After the last attempt at a pose, which failed by `error`: pauses where so many in a row were lost.
  /// @return whether it did, and the pose is to be tried again once the operator has resumed
  boost::asio::awaitable<bool> pause_for_losses(MeasuringTarget target, DeviceError error);

  CellDevices devices_;
  CampaignJournal& journal_;
  ArmMotion motion_;
  ReflectorSearch search_;
  bool in_journal_ = false;  ///< or that failed
  bool begun_ = false;       ///< the devices are known

  std::shared_ptr<const CampaignPast> past_;
  std::size_t past_left_ = 0;  ///< outcomes that were not taken yet
  bool has_resumed_ = false;
  std::function<CampaignOutcome<void>()> before_resuming_;
  std::set<int> in_plan_;  ///< numbers of the poses that the journal has

  std::shared_ptr<PoseSupply> poses_;
  int next_number_ = 1;  ///< of a pose
  int substitutes_ = 0;
  int lost_in_row_ = 0;  ///< poses that were tried for the last time and failed
  int last_lost_ = 0;    ///< the last of them
};

}  // namespace truepose::daemon
