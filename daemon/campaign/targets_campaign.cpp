#include <utility>

#include "config/cell_setup.hpp"
#include "core/formatted.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/campaign/stored_model.hpp"

namespace truepose::daemon {

namespace {

/// Why the loop has not reached its target; nothing where it has.
std::string why_not(const TrackerLoop& loop) {
  switch (*loop.end()) {
    case TrackerLoopEnd::Reached:
      return {};
    case TrackerLoopEnd::DoesNotFall:
      return "the error does not fall: the arm does not follow its corrections";
    case TrackerLoopEnd::OutOfReach:
      return formatted("an error of %.3f mm cannot be corrected within the joint limits",
                       loop.errors_mm().back());
    case TrackerLoopEnd::RoundsUsed:
      return formatted("after %zu rounds the mean of the readings is still %.4f mm off",
                       loop.errors_mm().size(), loop.averaged_error_mm());
  }
  return {};
}

class TargetsCampaign final : public CampaignProcedure {
 public:
  TargetsCampaign(MeasuringSession& session, TargetsOrder order);
  CampaignOutcome<void> run() override;

 private:
  /// Where the loop begins at one target, or why it does not.
  struct Start {
    JointVector q;
    std::string refusal;
  };

  CampaignOutcome<void> plan();
  CampaignOutcome<void> prepare();
  CampaignOutcome<void> close_in(MeasuringTarget target, Start start);

  MeasuringSession& session_;
  TargetsOrder order_;
  std::vector<MeasuringTarget> targets_;
  std::vector<Start> starts_;
};

}  // namespace

TargetsCampaign::TargetsCampaign(MeasuringSession& session, TargetsOrder order)
    : session_{session}, order_{std::move(order)} {
  session_.search().expect(order_.cell);
  session_.result().findings = TargetsResult{order_.loop, order_.readings, {}};
  const int targets = order_.targets.empty() ? session_.config().campaign.validate_poses
                                             : static_cast<int>(order_.targets.size());
  session_.progress().add_to_total(targets * order_.loop.rounds);
}

CampaignOutcome<void> TargetsCampaign::run() {
  Done done = co_await plan();
  if (done) done = co_await prepare();
  if (done) session_.progress().enter(CampaignPhase::Targets);
  for (std::size_t i = 0; done && i < targets_.size(); ++i) {
    const int before = session_.progress().now().left();
    done = co_await close_in(targets_[i], starts_[i]);
    session_.progress().add_to_total(before - session_.progress().now().left() - order_.loop.rounds);
  }
  co_return done;
}

CampaignOutcome<void> TargetsCampaign::plan() {
  const config::CellConfig& config = session_.config();
  PlanOptions options = config::plan_options(config, config.campaign.drift_poses);
  options.reference_every = 0;
  if (order_.targets.empty()) options.validate = config.campaign.validate_poses;
  Done done = co_await session_.plan().choose(known_cell(config, order_.cell), options);
  if (!done) co_return done;
  if (order_.targets.empty()) order_.targets = session_.plan().chosen().validate;
  for (const JointVector& q : order_.targets) {
    targets_.push_back(session_.plan().new_target(PointPurpose::Target, q));
    targets_.back().readings = order_.readings;
  }
  co_return done;
}

/// The joints that the active model asks for, and whether the arm may go there.
CampaignOutcome<void> TargetsCampaign::prepare() {
  session_.progress().enter(CampaignPhase::Compute);
  auto job = [targets = targets_, config = session_.config(), cell = order_.cell] {
    std::vector<Start> starts;
    const RobotModel& nominal = config.robot.model;
    PoseChecker checker{known_scene(config, cell)};
    for (const MeasuringTarget& target : targets) {
      const auto directions = approach_direction(target, nominal);
      const auto solved = compensated(target.q_target, directions, config, cell);
      if (!solved) {
        starts.push_back({{}, "compensated: " + described(solved.error(), nominal)});
      } else if (const auto fault = checker.fault_of(solved->q)) {
        starts.push_back({{}, "the pose " + std::string{fault_text(*fault)}});
      } else {
        starts.push_back({solved->q, {}});
      }
    }
    return starts;
  };
  starts_ = co_await session_.compute(job);
  std::vector<MeasuringTarget> kept = targets_;
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (starts_[i].refusal.empty()) kept[i].q_commanded = starts_[i].q;
  co_return co_await session_.plan().keep(std::move(kept));
}

CampaignOutcome<void> TargetsCampaign::close_in(MeasuringTarget target, Start start) {
  std::vector<TargetOutcome>& outcomes = session_.result().as<TargetsResult>().targets;
  outcomes.push_back({.q_target = target.q_target, .reason = start.refusal});
  TargetOutcome& outcome = outcomes.back();
  if (!start.refusal.empty()) co_return co_await session_.skip(target, 0, start.refusal);
  const CalibratedCell asked = known_cell(session_.config(), order_.cell);
  TrackerLoop loop{order_.cell, asked.predict(target.q_target, 0), start.q, order_.loop};
  MeasuringTarget round = target;
  while (!loop.end()) {
    if (!loop.errors_mm().empty()) round.pose = session_.plan().next_number();
    round.q_commanded = loop.q();
    auto point = co_await session_.measure(round);
    if (!point) co_return std::unexpected(point.error());
    if (!*point) {
      outcome.reason = session_.result().skipped.back().reason;
      break;
    }
    loop.add(*(*point)->p_WS_mm);
  }
  if (loop.errors_mm().empty()) co_return Done{};
  outcome.q = loop.q();
  outcome.errors_mm = loop.errors_mm();
  outcome.averaged_error_mm = loop.averaged_error_mm();
  outcome.reached = loop.end() == TrackerLoopEnd::Reached;
  if (loop.end()) outcome.reason = why_not(loop);
  co_return Done{};
}

std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, TargetsOrder order) {
  return std::make_unique<TargetsCampaign>(session, std::move(order));
}

}  // namespace truepose::daemon
