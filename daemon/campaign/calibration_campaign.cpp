#include <algorithm>
#include <memory>
#include <utility>

#include "config/cell_setup.hpp"
#include "config/model_file.hpp"
#include "core/formatted.hpp"
#include "core/math/units.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/campaign/identification.hpp"
#include "daemon/campaign/nest_watch.hpp"
#include "daemon/campaign/stored_model.hpp"
#include "proto/text/digest.hpp"

namespace truepose::daemon {

namespace {

/// By which an identification is known again, to the last digit.
std::string hash_of(const Calibration& calibration) {
  const config::ModelFile file{
      .cell = calibration.cell, .parameters = calibration.parameters, .covariance = calibration.covariance};
  return text::sha256_hex(config::model_yaml(file));
}

class CalibrationCampaign final : public CampaignProcedure {
 public:
  explicit CalibrationCampaign(MeasuringSession& session);
  CampaignOutcome<void> run() override;

 private:
  using Targets = std::vector<MeasuringTarget>;

  CampaignOutcome<void> plan();
  void add_reference(const JointVector& q);
  MeasuringTarget reference(const JointVector& q);
  CampaignOutcome<void> warm_up();
  CampaignOutcome<void> measure_to_identify();
  CampaignOutcome<void> measure_to_validate();
  CampaignOutcome<void> fit_placement();
  std::optional<CampaignError> too_few_left(std::size_t targets_done) const;
  CampaignOutcome<void> identify();
  boost::asio::awaitable<void> judge_again();
  void report_doubts();
  CampaignOutcome<void> remeasure();
  CampaignOutcome<Targets> compensate();
  void judge_remeasured();
  CalibrationResult& found() { return session_.result().as<CalibrationResult>(); }

  MeasuringSession& session_;
  NestWatch nests_{session_};
  Targets identify_, validate_;
};

}  // namespace

CalibrationCampaign::CalibrationCampaign(MeasuringSession& session) : session_{session} {
  const config::CampaignConfig& campaign = session_.config().campaign;
  session_.progress().add_to_total(campaign.identify_poses +
                                   campaign.validate_poses * (campaign.remeasure ? 2 : 1));
}

CampaignOutcome<void> CalibrationCampaign::run() {
  Done done = co_await plan();
  // One that continues is warmed up where it does.
  session_.before_resuming([this] { return warm_up(); });
  if (done && !session_.past().resumes()) done = co_await warm_up();
  if (done) done = co_await measure_to_identify();
  if (done) done = co_await measure_to_validate();
  if (done) done = co_await identify();
  if (done && session_.config().campaign.remeasure) done = co_await remeasure();
  co_return done;
}

CampaignOutcome<void> CalibrationCampaign::plan() {
  const config::CampaignConfig& campaign = session_.config().campaign;
  PlanOptions options = config::plan_options(session_.config(), campaign.identify_poses);
  options.first = std::min(campaign.coarse_after, campaign.identify_poses);
  options.validate = campaign.validate_poses;
  Done done =
      co_await session_.plan().choose(config::rough_cell(session_.config()), options, Reflectors::All);
  if (!done) co_return done;
  const MeasurementPlan& plan = session_.plan().chosen();
  for (const JointVector& q : plan.poses)
    identify_.push_back(session_.plan().new_target(PointPurpose::Identify, q, Replacement::Informative));
  for (const JointVector& q : plan.validate)
    validate_.push_back(session_.plan().new_target(PointPurpose::Validate, q, Replacement::Near));
  if (plan.reference) add_reference(*plan.reference);
  Targets all = identify_;
  all.insert(all.end(), validate_.begin(), validate_.end());
  co_return co_await session_.plan().keep(std::move(all));
}

/// Puts measurements of the reference pose before the first pose to identify, after every so many, and last.
void CalibrationCampaign::add_reference(const JointVector& q) {
  const auto every = static_cast<std::size_t>(session_.config().campaign.reference_every);
  Targets all;
  for (std::size_t i = 0; i < identify_.size(); ++i) {
    if (i % every == 0) all.push_back(reference(q));
    all.push_back(identify_[i]);
  }
  all.push_back(reference(q));
  session_.progress().add_to_total(static_cast<int>(all.size() - identify_.size()));
  identify_ = std::move(all);
}

/// Always come to from the same side: play of the joints is no drift.
MeasuringTarget CalibrationCampaign::reference(const JointVector& q) {
  MeasuringTarget target = session_.plan().new_target(PointPurpose::Reference, q);
  target.way_rad = session_.config().campaign.approach_deg * kRadPerDeg;
  return target;
}

CampaignOutcome<void> CalibrationCampaign::warm_up() {
  session_.progress().enter(CampaignPhase::WarmUp);
  const config::CampaignConfig& campaign = session_.config().campaign;
  const TimePoint until = session_.clock().now() + campaign.warm_up;
  for (std::size_t n = 0; static_cast<int>(n) < campaign.warm_up_moves || session_.clock().now() < until;
       ++n) {
    Done visited = co_await session_.visit(identify_[n % identify_.size()].q_target);
    if (!visited) co_return visited;
  }
  co_return Done{};
}

CampaignOutcome<void> CalibrationCampaign::measure_to_identify() {
  session_.progress().enter(CampaignPhase::Identify);
  Done seen = co_await nests_.measure();
  if (!seen) co_return seen;
  // With every further pose the fit reaches farther beyond those that it was made from.
  const auto after_each = [this, targets_done = std::size_t{0}]() mutable -> CampaignOutcome<void> {
    if (const auto hopeless = too_few_left(++targets_done)) co_return std::unexpected(*hopeless);
    const int poses = count_poses(session_.data().points);
    Done done = co_await nests_.after_pose();
    if (done && poses >= session_.config().campaign.coarse_after) done = co_await fit_placement();
    co_return done;
  };
  Targets targets = identify_;  // the warm-up drives to those that were planned
  co_return co_await session_.measure_all(targets, after_each);
}

/// Once so many poses were lost that no fit can succeed any more, there is nothing to continue for.
std::optional<CampaignError> CalibrationCampaign::too_few_left(std::size_t targets_done) const {
  const auto to_come = std::ranges::count(identify_.begin() + static_cast<std::ptrdiff_t>(targets_done),
                                          identify_.end(), PointPurpose::Identify, &MeasuringTarget::purpose);
  config::CellConfig reachable = session_.config();
  int& poses = reachable.campaign.identify_poses;
  poses = static_cast<int>(to_come) + count_poses(session_.data().points);
  if (poses == session_.config().campaign.identify_poses) return std::nullopt;
  const auto why = config::too_few_poses(reachable);
  if (!why) return std::nullopt;
  return CampaignError{CampaignFault::Calibration,
                       "too many poses were lost: of those to identify from, " + *why};
}

CampaignOutcome<void> CalibrationCampaign::measure_to_validate() {
  session_.progress().enter(CampaignPhase::Validate);
  const auto after_each = [this] { return nests_.after_pose(); };
  Done done = co_await session_.measure_all(validate_, after_each);
  if (!done) co_return done;
  const auto& last_reference = session_.plan().chosen().reference;
  if (last_reference && !validate_.empty()) {
    // What moved while it was validated shows as well.
    session_.progress().add_to_total(1);
    auto visited = co_await session_.measure(reference(*last_reference));
    if (!visited) co_return std::unexpected(visited.error());
  }
  co_return co_await nests_.measure();
}

/// Base and reflector from the points so far, with the nominal arm: from now on the tracker knows where to
/// look.
CampaignOutcome<void> CalibrationCampaign::fit_placement() {
  auto job = [robot = session_.config().robot.model, data = session_.data()] {
    return coarse_fit(robot, data);
  };
  auto fitted = co_await session_.compute(job);
  if (!fitted) {
    // What served so far continues serving; the next point brings another try.
    session_.observer().on_trouble("base and reflector are not known yet: " + fitted.error().detail);
    co_return Done{};
  }
  const CalibratedCell& cell = *fitted;
  const std::vector<std::string> names = session_.data().smr_names;
  const std::vector<StoredPoint> points = session_.corrected().points;
  for (const StoredPoint& point : points) {
    const auto smr = std::ranges::find(names, point.smr) - names.begin();
    const double off_mm = (*point.p_WS_mm - cell.predict(point.q_actual, static_cast<int>(smr))).norm();
    if (off_mm <= session_.config().tracker.gate_mm) continue;
    const std::string text = formatted(
        "the %zu points so far do not fit the nominal arm: pose %d is %.1f mm off, allowed are "
        "%.1f mm (another reflector in sight, or another arm)",
        points.size(), point.pose, off_mm, session_.config().tracker.gate_mm);
    co_return std::unexpected(CampaignError{CampaignFault::Calibration, text});
  }
  // A fit from few points is good where they are, and less so elsewhere.
  const int to_identify = count_poses(session_.data().points);
  const bool few = to_identify < 2 * session_.config().campaign.coarse_after;
  session_.search().expect(cell, few ? 2 : 1);
  co_return Done{};
}

CampaignOutcome<void> CalibrationCampaign::identify() {
  session_.progress().enter(CampaignPhase::Compute);
  const TimePoint begun = session_.clock().now();
  const CampaignResult& measured = session_.result();
  auto job = [points = measured.points, config = session_.config(), resumptions = measured.resumptions] {
    return identified(points, config, resumptions);
  };
  auto result = co_await session_.compute(job);
  if (!result) co_return std::unexpected(CampaignError{CampaignFault::Calibration, result.error()});
  found() = *std::move(result);
  found().elapsed_s = std::chrono::duration<double>(session_.clock().now() - begun).count();
  Done kept = co_await session_.past().keep_identified(hash_of(found().calibration));
  if (!kept) co_return kept;
  report_doubts();
  session_.search().expect(found().calibration.cell);
  co_return Done{};
}

/// Asks again whether the model may be trusted, by all that was measured since.
boost::asio::awaitable<void> CalibrationCampaign::judge_again() {
  // The session outlives the job, and does nothing else meanwhile.
  auto job = [this] {
    const CampaignResult& measured = session_.result();
    return verdict_on(found(), measured.points, session_.config(), measured.resumptions);
  };
  found().verdict = co_await session_.compute(job);
  report_doubts();
}

void CalibrationCampaign::report_doubts() {
  for (const Finding& finding : found().verdict.findings)
    if (finding.severity >= Severity::Warning)
      session_.observer().on_trouble("the model is in doubt: " + finding.sentence);
}

CampaignOutcome<void> CalibrationCampaign::remeasure() {
  auto compensated = co_await compensate();
  if (!compensated) co_return std::unexpected(compensated.error());
  session_.progress().enter(CampaignPhase::Remeasure);
  const auto after_each = [this] { return nests_.after_pose(); };
  Done done = co_await session_.measure_all(*compensated, after_each);
  if (done) done = co_await nests_.measure();
  if (!done) co_return done;
  judge_remeasured();
  if (found().remeasured) co_await judge_again();
  co_return Done{};
}

/// The validation poses again, now with the joints at which the real arm stands where the nominal one would.
CampaignOutcome<CalibrationCampaign::Targets> CalibrationCampaign::compensate() {
  Targets targets = validate_;
  for (MeasuringTarget& target : targets)
    target = session_.plan().new_target(PointPurpose::Remeasure, target.q_target);
  auto job = [targets, config = session_.config(), expected = session_.search().expected()] {
    std::vector<TargetCompensation::Result> results;
    for (const MeasuringTarget& target : targets) {
      const auto directions = approach_direction(target, config.robot.model);
      results.push_back(compensated(target.q_target, directions, config, expected));
    }
    return results;
  };
  auto solved = co_await session_.compute(job);

  Targets reachable;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    std::string reason;
    if (found().verdict.failed()) {
      reason = "the arm is not led by a model that is in doubt: " + found().verdict.findings.front().sentence;
    } else if (!solved[i]) {
      reason = "compensated: " + described(solved[i].error(), session_.config().robot.model);
    }
    if (!reason.empty()) {
      Done skipped = co_await session_.skip(targets[i], 0, reason);
      if (!skipped) co_return std::unexpected(skipped.error());
      continue;
    }
    targets[i].q_commanded = solved[i]->q;
    reachable.push_back(targets[i]);
  }
  Done kept = co_await session_.plan().keep(reachable);
  if (!kept) co_return std::unexpected(kept.error());
  co_return reachable;
}

void CalibrationCampaign::judge_remeasured() {
  CalibrationResult& result = found();
  const CalibratedCell& cell = result.calibration.cell;
  // Where the nominal arm was asked to be, seen from the identified base.
  const CalibratedCell asked{session_.config().robot.model, cell.base, cell.reflectors};
  std::vector<Eigen::Vector3d> errors_mm;
  for (const StoredPoint& point : session_.corrected().points) {
    if (point.purpose != PointPurpose::Remeasure) continue;
    const auto smr = std::ranges::find(cell.reflectors, point.smr, &Reflector::name);
    if (smr == cell.reflectors.end()) continue;  // that nothing was identified of
    const auto index = static_cast<int>(smr - cell.reflectors.begin());
    errors_mm.push_back(*point.p_WS_mm - asked.predict(point.q_target, index));
    result.remeasured_points.push_back({point, errors_mm.back()});
  }
  if (!errors_mm.empty()) result.remeasured = error_statistics(errors_mm);
}

std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, CalibrationOrder) {
  return std::make_unique<CalibrationCampaign>(session);
}

}  // namespace truepose::daemon
