#pragma once

#include <boost/asio/awaitable.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/campaign/session_past.hpp"
#include "daemon/campaign/session_plan.hpp"

namespace truepose::daemon {

/// What every campaign does: comes to one pose after the other by a clear way, measures it, tries again,
/// recovers lost devices, keeps each point in the journal before the arm moves on, and reports how far it is.
/// A pose ends as a point or as a skipped pose with its reason.
///
/// One that continues takes from its past what was measured or skipped. Before the first step that is not
/// there it finds what has moved meanwhile. Points are given, and places asked for, in the frame in which the
/// tracker stood when the campaign began.
class MeasuringSession : public CampaignRun {
 public:
  /// What is referred to outlives the session, see CampaignRun.
  MeasuringSession(const config::CellConfig& config, CampaignDevices devices, CampaignJournal& journal,
                   CampaignObserver& observer, RunJob run_compute,
                   std::shared_ptr<const CampaignPast> past = {});

  /// Begins the journal, connects the devices, and sees by small motions that the arm is the configured one;
  /// of one that is not to be moved, as far as it shows that where it stands.
  /// @param model_serial  of the arm by whose model the campaign works; empty: it works by none
  CampaignOutcome<void> connect(CampaignNeeds needs, std::string model_serial);
  /// The arm may have moved.
  bool has_begun() const { return begun_; }
  /// Ends the journal, with the result where there is no error.
  boost::asio::awaitable<StoreResult<void>> end(std::optional<CampaignError> error);

  CellDevices& devices() { return devices_.cell(); }
  ReflectorSearch& search() { return devices_.search(); }
  SessionPlan& plan() { return plan_; }
  SessionPast& past() { return past_; }
  /// What is done before it is found what has moved: the arm has to be as warm as it was.
  void before_resuming(std::function<CampaignOutcome<void>()> act) { before_resuming_ = std::move(act); }
  /// Pauses for an operator action, which the sentence asks for, until the operator resumes. Does nothing if
  /// the next point was measured before an interruption.
  boost::asio::awaitable<void> wait_for_operator(std::string sentence);

  /// Drives there without measuring; a failure is dealt with, not repeated.
  CampaignOutcome<void> visit(JointVector q);
  /// @return the point, of the first reflector that was measured, or nothing where the pose was skipped
  CampaignOutcome<std::optional<StoredPoint>> measure(MeasuringTarget target);
  /// Measures all. Waits where the campaign is paused.
  /// @param targets  of which those that fail are replaced by their substitutes
  /// @param after_each  is run after each pose that was not replaced
  CampaignOutcome<void> measure_all(std::vector<MeasuringTarget>& targets,
                                    std::function<CampaignOutcome<void>()> after_each = {});
  CampaignOutcome<void> skip(MeasuringTarget target, int attempts, std::string reason);
  /// @return nothing if it was not seen, which is reported
  CampaignOutcome<std::optional<StoredPoint>> measure_fixed(FixedReflector what, Eigen::Vector3d p_W_mm,
                                                            double search_mm);
  /// Measures a point of before once more, see SessionDevices::read_again().
  /// @return where the tracker sees it now, in its own frame; nothing where it does not
  CampaignOutcome<std::optional<Eigen::Vector3d>> measure_again(StoredPoint before, Eigen::Vector3d p_W_mm);
  /// Waits until the operator has jogged the arm so that its TCP touches the point, and keeps its joint
  /// positions. Asks again, and says why, where the arm still moves, has not been moved since the touch
  /// before, or cannot be asked.
  /// @param request  what the operator is asked to do, as a sentence
  CampaignOutcome<void> touch(int number, std::string point, std::string request);

 private:
  boost::asio::awaitable<StoreResult<void>> begin();
  CampaignOutcome<void> resume_from_past();
  boost::asio::awaitable<bool> pause_for_losses(MeasuringTarget target, DeviceError error);
  CellDevices::Outcome<JointVector> jogged_to();
  using Points = std::vector<StoredPoint>;
  CampaignOutcome<StoredPoint> keep(Points points);
  using Attempt = std::function<CellDevices::Outcome<StoredPoint>()>;
  CampaignOutcome<std::optional<StoredPoint>> store_first(std::string name, Attempt attempt);
  CampaignOutcome<StoredPoint> store(StoredPoint point);
  double count_deviation(const StoredPoint& point);

  CampaignJournal& journal_;
  SessionDevices devices_;
  SessionPlan plan_;
  SessionPast past_;
  std::function<CampaignOutcome<void>()> before_resuming_;
  bool in_journal_ = false;  ///< or that failed
  bool begun_ = false;       ///< the devices are known
  int lost_in_row_ = 0;      ///< poses that were tried for the last time and failed
  int last_lost_ = 0;        ///< the last of them
};

}  // namespace truepose::daemon
