#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <expected>
#include <memory>
#include <string>

#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

/// What one kind of campaign does with a session once the devices are connected. Made before that, when it
/// says how many poses there will be.
class CampaignProcedure {
 public:
  virtual ~CampaignProcedure() = default;
  virtual CampaignOutcome<void> run() = 0;
  /// An arm that moves is proven by small motions first.
  virtual CampaignNeeds needs() const { return {}; }
};

/// Identifies the arm from planned poses, validates on others, and proves by measuring again that
/// compensation works.
///
/// The poses are numbered: those planned to identify, those planned to validate, then what comes up on the
/// way (measurements of the reference pose, substitutes of poses that failed), then the validation poses
/// again with compensated joints.
std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, CalibrationOrder);

/// Measures a few poses and judges whether the active model is still right; brings it up to date by them
/// where that is ordered.
std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, DriftOrder order);

/// Finds for each target the joints at which the real arm stands there: starts from those of the active
/// model, and corrects them by the tracker in the loop. A target is where the nominal arm would hold the
/// reflector, seen from the model's base.
std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, TargetsOrder order);

/// Measures the cycles of an ISO 9283 test (P5 to P1, each from the one before, then P4, P2 and P1 along each
/// axis where that was ordered), and evaluates them. With a model, accuracy is that in the robot's base;
/// without, the frame is fitted to the five points.
///
/// The poses are numbered as they are measured, as many to a cycle as it has stops.
std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, Iso9283Order order);

/// Measures the points of a tool in poses that turn the flange as differently as the tracker sees them, and
/// finds its frame by the active model. Where a reflector is put from point to point by hand, it pauses
/// before each but the first. The poses are numbered as they are measured.
///
/// The session's cell is that of cell_with_tool().
std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, ToolOrder order);

/// Has a reflector put by hand to one point of a fixture after the other, or the arm jogged so that its TCP
/// touches it, for which it pauses, and finds the work frame. It moves the arm nowhere itself.
std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, BaseOrder order);

/// One campaign, from connecting the devices to the end in the journal.
class Campaign {
 public:
  /// What is referred to outlives run().
  /// @param past  of a campaign that was interrupted and is to continue; null: it begins
  Campaign(config::CellConfig config, CampaignDevices devices, CampaignJournal& journal,
           CampaignObserver& observer, RunJob run_compute, CampaignOrder order = CalibrationOrder{},
           std::shared_ptr<const CampaignPast> past = {});

  /// Runs the whole campaign, once. It ends in the journal in every case. End it early by abort(), not by
  /// cancelling.
  boost::asio::awaitable<std::expected<std::shared_ptr<const CampaignResult>, CampaignError>> run();

  /// Takes effect before the next pose.
  void pause() { session_.pause().begin(); }
  void resume() { session_.pause().end(); }
  /// Stops the arm. run() then returns Aborted with this reason, and says where the arm could not be stopped.
  void abort(std::string reason);
  /// The same, but a campaign of a kind that may continue ends as interrupted.
  void interrupt(std::string reason);

  CampaignProgress progress() const { return session_.progress().now(); }
  CampaignNeeds needs() const { return procedure_->needs(); }
  /// Whether it is paused for want of room in the store.
  bool waits_for_room() const { return session_.waits_for_room(); }

 private:
  CampaignOutcome<void> steps();

  config::CellConfig config_;
  std::string reason_not_resumable_;  ///< where it cannot continue; else empty
  std::string model_serial_;          ///< of the arm by whose model it works; empty: it works by none
  MeasuringSession session_;
  std::unique_ptr<CampaignProcedure> procedure_;
  bool aborting_ = false, interrupting_ = false;
  std::string abort_reason_;
  boost::asio::cancellation_signal cancel_;
};

}  // namespace truepose::daemon
