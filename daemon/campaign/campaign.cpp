#include "daemon/campaign/campaign.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cstdio>
#include <utility>

#include "config/cell_setup.hpp"
#include "core/compensation/target_compensation.hpp"
#include "core/evaluation/model_noise.hpp"
#include "core/kinematics/angles.hpp"
#include "core/kinematics/forward.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using namespace std::chrono_literals;

namespace {

constexpr Duration kBeforeRetry = 1s;

// A joint that moved less than this has not taken up its backlash.
constexpr double kMoved = 1e-4;

using Done = std::expected<void, CampaignError>;

/// A device's error that ends the campaign.
CampaignError fatal(const DeviceError& error) {
  return {error.remedy == Remedy::WrongArm ? CampaignFault::WrongArm : CampaignFault::Device, error.detail};
}

CampaignError store_failed(const StoreError& error) { return {CampaignFault::Store, error.detail}; }

/// The way by which every joint comes to a pose, where the campaign prescribes a side: rad, from below where
/// positive.
double approach_way_rad(const config::CampaignConfig& campaign, int pose) {
  const double way_rad = campaign.approach_deg * kRadPerDeg;
  switch (campaign.approach) {
    case config::ApproachSide::Any:
      return 0;
    case config::ApproachSide::Upwards:
      return way_rad;
    case config::ApproachSide::Alternate:
      return pose % 2 == 0 ? way_rad : -way_rad;
  }
  return 0;
}

}  // namespace

std::string_view phase_name(CampaignPhase phase) {
  constexpr std::array<std::string_view, 8> names{"connecting", "computing", "warming_up",  "identifying",
                                                  "validating", "computing", "remeasuring", "activating"};
  return names[static_cast<std::size_t>(phase)];
}

Campaign::Campaign(config::CellConfig config, CampaignDevices devices, CampaignJournal& journal,
                   CampaignObserver& observer, RunCompute run_compute,
                   std::optional<DriftReference> drift_reference)
    : config_{std::move(config)},
      devices_{config_, devices, [&observer](const std::string& sentence) { observer.on_trouble(sentence); }},
      clock_{devices.clock},
      journal_{journal},
      observer_{observer},
      run_compute_{std::move(run_compute)},
      expected_{config::rough_cell(config_)},
      result_{std::make_shared<CampaignResult>()} {
  const config::CampaignConfig& plan = config_.campaign;
  progress_.total = plan.identify_poses + plan.validate_poses * (plan.remeasure ? 2 : 1);
  if (drift_reference) {
    progress_.total = plan.drift_poses;
    expected_ = drift_reference->cell;
    placement_known_ = true;
    result_->kind = CampaignKind::DriftCheck;
    result_->drift_reference = std::move(drift_reference);
  }
  result_->data.smr_names = {config_.reflector.name};
}

asio::awaitable<std::expected<std::shared_ptr<const CampaignResult>, CampaignError>> Campaign::run() {
  const auto executor = co_await asio::this_coro::executor;
  resumed_ = std::make_unique<asio::steady_timer>(executor);
  std::optional<CampaignError> error;
  if (!aborting_) {
    // The steps have a cancellation of their own, so that after an abort the arm can still be stopped and the
    // end written.
    auto token = asio::bind_cancellation_slot(cancel_.slot(), asio::use_awaitable);
    try {
      Done done = co_await asio::co_spawn(executor, steps(), token);
      if (!done) error = done.error();
    } catch (const std::exception& e) {
      error = CampaignError{CampaignFault::Internal, e.what()};
    }
  }
  if (aborting_) {
    error = CampaignError{CampaignFault::Aborted, abort_reason_};
    co_await devices_.stop();
  }
  auto ended = co_await end_in_journal(error);
  if (!ended && !error) error = store_failed(ended.error());
  if (error) co_return std::unexpected(*error);
  co_return std::shared_ptr<const CampaignResult>{result_};
}

Campaign::Outcome<void> Campaign::steps() {
  Done done = co_await connect();
  if (done) done = co_await plan();
  // Not by ?:, of which this compiler awaits both sides.
  if (done && result_->kind == CampaignKind::DriftCheck) {
    done = co_await drift_steps();
  } else if (done) {
    done = co_await calibration_steps();
  }
  if (done) enter(CampaignPhase::Finish);
  co_return done;
}

Campaign::Outcome<void> Campaign::drift_steps() {
  Done done = co_await measure_all(CampaignPhase::Validate, validate_);
  if (done) done = co_await judge_drift();
  co_return done;
}

Campaign::Outcome<void> Campaign::calibration_steps() {
  Done done = co_await warm_up();
  if (done) done = co_await measure_all(CampaignPhase::Identify, identify_);
  if (done) done = co_await measure_all(CampaignPhase::Validate, validate_);
  if (done) done = co_await identify();
  if (done && config_.campaign.remeasure) {
    auto compensated = co_await compensate();
    if (compensated) {
      done = co_await measure_all(CampaignPhase::Remeasure, *compensated);
      judge_remeasured();
    } else {
      done = std::unexpected(compensated.error());
    }
  }
  co_return done;
}

Campaign::Outcome<void> Campaign::connect() {
  enter(CampaignPhase::Connect);
  auto identities = co_await devices_.connect();
  if (!identities) co_return std::unexpected(fatal(identities.error()));
  result_->identities = *std::move(identities);
  begun_ = true;
  auto begun = co_await journal_.begin(result_->identities);
  if (!begun) co_return std::unexpected(store_failed(begun.error()));
  co_return Done{};
}

Campaign::Outcome<void> Campaign::plan() {
  enter(CampaignPhase::Plan);
  const config::CampaignConfig& campaign = config_.campaign;
  const bool checks = result_->kind == CampaignKind::DriftCheck;
  PlanOptions options =
      config::plan_options(config_, checks ? campaign.drift_poses : campaign.identify_poses);
  if (checks) {
    // What tells most of all parameters, so that whatever changed shows.
    options.criterion = DesignCriterion::D;
    options.reference_every = 0;
  } else {
    options.first = std::min(campaign.coarse_after, campaign.identify_poses);
    options.validate = campaign.validate_poses;
  }
  options.sizes.clear();
  options.random_sets = 0;
  auto here = co_await devices_.position();
  if (here) options.start = *here;

  auto made = std::make_shared<std::expected<PoseSupply, std::string>>(std::unexpect);
  std::function<void()> job = [made, cell = planning_cell(), scene = config::scene_of(config_), options] {
    *made = PoseSupply::make(cell, scene, options);
  };
  co_await run_compute_(job);
  if (!*made) co_return std::unexpected(CampaignError{CampaignFault::Planning, made->error()});
  poses_ = std::make_shared<PoseSupply>(std::move(**made));

  const MeasurementPlan& plan = poses_->plan();
  const auto target = [this](PointPurpose purpose, const JointVector& q) {
    return Target{next_number_++, purpose, q, q};
  };
  for (const JointVector& q : plan.poses) {
    checks ? validate_.push_back(target(PointPurpose::Validate, q))
           : identify_.push_back(target(PointPurpose::Identify, q));
  }
  for (const JointVector& q : plan.validate) validate_.push_back(target(PointPurpose::Validate, q));
  if (plan.reference) add_reference(*plan.reference);
  co_return Done{};
}

/// The nominal arm, placed as well as it is known.
CalibratedCell Campaign::planning_cell() const {
  CalibratedCell cell = config::rough_cell(config_);
  if (result_->kind == CampaignKind::DriftCheck) {
    cell.base = expected_.base;
    cell.reflectors = expected_.reflectors;
  }
  return cell;
}

/// Puts measurements of the reference pose before the first pose to identify, after every so many, and last.
void Campaign::add_reference(const JointVector& q) {
  const auto every = static_cast<std::size_t>(config_.campaign.reference_every);
  std::vector<Target> all;
  const auto visit = [&] { all.push_back({next_number_++, PointPurpose::Reference, q, q}); };
  for (std::size_t i = 0; i < identify_.size(); ++i) {
    if (i % every == 0) visit();
    all.push_back(identify_[i]);
  }
  visit();
  progress_.total += static_cast<int>(all.size() - identify_.size());
  identify_ = std::move(all);
}

Campaign::Outcome<void> Campaign::warm_up() {
  enter(CampaignPhase::WarmUp);
  const TimePoint until = clock_.now() + config_.campaign.warm_up;
  for (std::size_t n = 0; static_cast<int>(n) < config_.campaign.warm_up_moves || clock_.now() < until; ++n) {
    co_await wait_while_paused();
    auto reached = co_await drive(identify_[n % identify_.size()].q_target);
    if (reached) continue;
    Done recovered = co_await recover(reached.error());
    if (!recovered) co_return recovered;
  }
  co_return Done{};
}

Campaign::Outcome<void> Campaign::measure_all(CampaignPhase phase, std::vector<Target> targets) {
  enter(phase);
  if (!first_pose_) first_pose_ = clock_.now();
  for (std::size_t i = 0; i < targets.size(); ++i) {
    co_await wait_while_paused();
    auto measured = co_await measure_or_skip(targets[i]);
    if (!measured) co_return std::unexpected(measured.error());
    if (!*measured) {
      auto other = co_await substitute(targets[i]);
      if (!other) co_return std::unexpected(other.error());
      if (*other) targets.insert(targets.begin() + static_cast<std::ptrdiff_t>(i) + 1, **other);
    }
    // With every further pose to identify from the fit reaches farther beyond those that it was made from.
    if (phase == CampaignPhase::Identify &&
        static_cast<int>(result_->data.points.size()) >= config_.campaign.coarse_after) {
      Done fitted = co_await fit_placement();
      if (!fitted) co_return fitted;
    }
  }
  co_return Done{};
}

Campaign::Outcome<bool> Campaign::measure_or_skip(Target target) {
  const int attempts = 1 + config_.campaign.retries;
  std::string reason;
  for (int n = 1; n <= attempts; ++n) {
    auto point = co_await attempt(target);
    if (point) {
      Done kept = co_await keep(*point);
      if (!kept) co_return std::unexpected(kept.error());
      co_return true;
    }
    reason = point.error().detail;
    observer_.on_trouble("pose " + std::to_string(target.pose) + ", attempt " + std::to_string(n) + " of " +
                         std::to_string(attempts) + ": " + reason);
    Done recovered = co_await recover(point.error());
    if (!recovered) co_return std::unexpected(recovered.error());
  }
  Done skipped = co_await skip(target, attempts, reason);
  if (!skipped) co_return std::unexpected(skipped.error());
  co_return false;
}

/// What to measure in place of a pose that failed. Never more than were measured, so that a device that
/// always fails does not make the campaign endless.
Campaign::Outcome<std::optional<Campaign::Target>> Campaign::substitute(Target failed) {
  const bool planned = failed.purpose == PointPurpose::Identify || failed.purpose == PointPurpose::Validate;
  if (!planned || substitutes_ >= static_cast<int>(result_->points.size())) co_return std::nullopt;
  auto other = std::make_shared<std::optional<JointVector>>();
  const bool informative =
      failed.purpose == PointPurpose::Identify || result_->kind == CampaignKind::DriftCheck;
  std::function<void()> job = [other, poses = poses_, failed, informative] {
    *other = informative ? poses->substitute(failed.q_target) : poses->validation_substitute(failed.q_target);
  };
  co_await run_compute_(job);
  if (!*other) co_return std::nullopt;
  ++substitutes_;
  ++progress_.total;
  const Target target{next_number_++, failed.purpose, **other, **other};
  if (failed.purpose == PointPurpose::Validate) {
    *std::ranges::find(validate_, failed.pose, &Target::pose) = target;
  }
  observer_.on_trouble("pose " + std::to_string(failed.pose) + " is replaced by pose " +
                       std::to_string(target.pose));
  co_return target;
}

/// Moves to q by a way that is clear, as far as the arm's surroundings are known.
asio::awaitable<std::expected<JointVector, DeviceError>> Campaign::drive(JointVector q) {
  auto here = co_await devices_.position();
  if (!here) co_return here;
  auto way = std::make_shared<std::optional<std::vector<JointVector>>>();
  std::function<void()> job = [way, poses = poses_, from = *here, q] { *way = poses->way(from, q); };
  co_await run_compute_(job);
  if (!*way) {
    co_return std::unexpected(
        DeviceError{Remedy::Retry, "no clear way was found from where the arm stands; move it by hand"});
  }
  (*way)->push_back(q);
  for (const JointVector& stop : **way) {
    const JointVector from = *here;
    here = co_await devices_.move(stop);
    if (!here) co_return here;
    direction_.resize(static_cast<std::size_t>(here->size()));
    for (std::size_t i = 0; i < direction_.size(); ++i) {
      const double moved = (*here - from)[static_cast<Eigen::Index>(i)];
      if (std::abs(moved) > kMoved) direction_[i] = moved > 0 ? 1 : -1;
    }
  }
  co_return here;
}

/// Moves to a target from the side that the campaign prescribes.
asio::awaitable<std::expected<JointVector, DeviceError>> Campaign::arrive(Target target) {
  const double way_rad = approach_way_rad(config_.campaign, target.pose);
  if (way_rad != 0) {
    auto start = co_await drive(approach_start(config_.robot.model, target.q_commanded, way_rad));
    if (!start) co_return start;
  }
  auto reached = co_await drive(target.q_commanded);
  co_return reached;
}

asio::awaitable<std::expected<StoredPoint, DeviceError>> Campaign::attempt(Target target) {
  auto reached = co_await arrive(target);
  if (!reached) co_return std::unexpected(reached.error());
  const config::TrackerConfig& tracker = config_.tracker;
  const Eigen::Vector3d p_WS_mm = expected_.predict(*reached, 0, direction_);
  // A fit from few points is good where they are, and less so elsewhere.
  const double reach =
      static_cast<int>(result_->data.points.size()) < 2 * config_.campaign.coarse_after ? 2 : 1;
  const double search_mm = placement_known_ ? reach * tracker.search_mm : tracker.search_first_mm;
  const double gate_mm = placement_known_ ? reach * tracker.gate_mm : tracker.search_first_mm;
  auto measured = co_await devices_.measure(p_WS_mm, search_mm, gate_mm);
  if (!measured) co_return std::unexpected(measured.error());

  StoredPoint point;
  point.pose = target.pose;
  point.purpose = target.purpose;
  point.q_target = target.q_target;
  point.q_commanded = target.q_commanded;
  point.q_actual = *reached;
  point.direction = direction_;
  point.smr = config_.reflector.name;
  point.p_WS_mm = measured->p_WS_mm;
  point.std_mm = measured->std_mm;
  point.temperature_c = measured->temperature_c;
  point.pressure_mbar = measured->pressure_mbar;
  point.humidity_percent = measured->humidity_percent;
  co_return point;
}

/// On the disk first: what the arm moves on from is never lost.
Campaign::Outcome<void> Campaign::keep(StoredPoint point) {
  auto stored = co_await journal_.add_point(point);
  if (!stored) co_return std::unexpected(store_failed(stored.error()));
  result_->points.push_back(point);
  if (point.purpose == PointPurpose::Reference) note_reference(point);
  if (point.purpose == PointPurpose::Identify || point.purpose == PointPurpose::Validate) {
    Measurement measurement;
    measurement.q = point.q_actual;
    measurement.direction = point.direction;
    measurement.p_WS_mm = point.p_WS_mm;
    measurement.set = point.purpose == PointPurpose::Identify ? PoseSet::Identify : PoseSet::Validate;
    result_->data.points.push_back(measurement);
  }
  const double deviation_mm = (point.p_WS_mm - expected_.predict(point.q_actual, 0, point.direction)).norm();
  if (placement_known_) count_error(deviation_mm);
  count_pose();
  observer_.on_point(point, deviation_mm, progress_);
  co_return Done{};
}

/// How far the reference pose is from where it was first: drift of the tracker, the base or the arm.
void Campaign::note_reference(const StoredPoint& point) {
  if (!reference_mm_) reference_mm_ = point.p_WS_mm;
  result_->reference_drift_mm.push_back((point.p_WS_mm - *reference_mm_).norm());
}

Campaign::Outcome<void> Campaign::skip(Target target, int attempts, std::string reason) {
  const SkippedPose skipped{target.pose, reason, attempts};
  auto stored = co_await journal_.add_skipped(skipped);
  if (!stored) co_return std::unexpected(store_failed(stored.error()));
  result_->skipped.push_back(skipped);
  ++progress_.skipped;
  count_pose();
  observer_.on_skipped(skipped, progress_);
  co_return Done{};
}

/// After a failed attempt: whatever lets the next one succeed. Fails where there is to be no next one.
Campaign::Outcome<void> Campaign::recover(DeviceError error) {
  if (error.remedy == Remedy::GiveUp || error.remedy == Remedy::WrongArm)
    co_return std::unexpected(fatal(error));
  if (error.remedy == Remedy::Retry) {
    const TimePoint next = clock_.now() + kBeforeRetry;
    co_await clock_.sleep_until(next);
    co_return Done{};
  }
  auto recovered = co_await devices_.recover(error.remedy);
  if (!recovered) co_return std::unexpected(fatal(recovered.error()));
  co_return Done{};
}

/// Base and reflector from the points so far, with the nominal arm: from now on the tracker knows where to
/// look.
Campaign::Outcome<void> Campaign::fit_placement() {
  auto fitted = std::make_shared<std::expected<CalibratedCell, CalibrationError>>();
  std::function<void()> job = [fitted, robot = config_.robot.model, data = result_->data] {
    *fitted = coarse_fit(robot, data);
  };
  co_await run_compute_(job);
  if (!*fitted) {
    // What served so far goes on serving; the next point brings another try.
    observer_.on_trouble("base and reflector are not known yet: " + fitted->error().detail);
    co_return Done{};
  }
  const CalibratedCell& cell = **fitted;
  for (std::size_t i = 0; i < result_->points.size(); ++i) {
    const StoredPoint& point = result_->points[i];
    const double off_mm = (point.p_WS_mm - cell.predict(point.q_actual, 0)).norm();
    if (off_mm <= config_.tracker.gate_mm) continue;
    char text[200];
    std::snprintf(text, sizeof text,
                  "the %zu points so far do not fit the nominal arm: pose %d is %.1f mm off, allowed are "
                  "%.1f mm (another "
                  "reflector in sight, or another arm)",
                  result_->points.size(), point.pose, off_mm, config_.tracker.gate_mm);
    co_return std::unexpected(CampaignError{CampaignFault::Calibration, text});
  }
  expected_ = cell;
  placement_known_ = true;
  co_return Done{};
}

Campaign::Outcome<void> Campaign::identify() {
  enter(CampaignPhase::Compute);
  auto calibrated = std::make_shared<std::expected<Calibration, CalibrationError>>();
  std::function<void()> job = [calibrated, robot = config_.robot.model, data = result_->data,
                               options = config::calibrate_options(config_)] {
    *calibrated = calibrate(robot, data, options);
  };
  const TimePoint begun = clock_.now();
  co_await run_compute_(job);
  result_->elapsed_s = std::chrono::duration<double>(clock_.now() - begun).count();
  if (!*calibrated) {
    co_return std::unexpected(CampaignError{CampaignFault::Calibration, calibrated->error().detail});
  }
  Calibration& calibration = **calibrated;
  if (!calibration.converged) {
    co_return std::unexpected(
        CampaignError{CampaignFault::Calibration, "the identification did not converge"});
  }
  result_->calibration = std::move(calibration);
  result_->noise =
      noise_about_model(result_->calibration, result_->data, config::calibrate_options(config_).noise);
  const auto& validate = result_->calibration.validate;
  result_->improves = validate && validate->after.mean < validate->before.mean;
  expected_ = result_->calibration.cell;
  placement_known_ = true;
  co_return Done{};
}

Campaign::Outcome<void> Campaign::judge_drift() {
  enter(CampaignPhase::Compute);
  std::vector<Measurement> points = result_->data.points;
  for (std::size_t i = 0; i < points.size(); ++i) points[i].row = static_cast<int>(i) + 1;
  auto check = std::make_shared<std::expected<DriftCheck, std::string>>();
  std::function<void()> job = [check, reference = *result_->drift_reference, points] {
    *check = drift_check(reference, points);
  };
  co_await run_compute_(job);
  if (!*check) co_return std::unexpected(CampaignError{CampaignFault::Calibration, check->error()});
  result_->data.points = std::move(points);
  result_->drift = **check;
  co_return Done{};
}

/// The validation poses again, now with the joints at which the real arm stands where the nominal one would.
Campaign::Outcome<std::vector<Campaign::Target>> Campaign::compensate() {
  std::vector<Target> targets = validate_;
  for (Target& target : targets) {
    target.pose = next_number_++;
    target.purpose = PointPurpose::Remeasure;
  }
  const RobotModel& nominal = config_.robot.model;
  auto solved = std::make_shared<std::vector<TargetCompensation::Result>>();
  std::function<void()> job = [solved, targets, nominal, expected = expected_, campaign = config_.campaign] {
    for (const Target& target : targets) {
      const double way_rad = approach_way_rad(campaign, target.pose);
      const auto side = static_cast<std::int8_t>((way_rad > 0) - (way_rad < 0));
      const std::vector<std::int8_t> direction(nominal.joints.size(), side);
      const TargetCompensation compensation{nominal, expected.robot, {.approach = direction}};
      // Next to the wrist singularity the reflector's position is kept: it is what will be measured.
      solved->push_back(compensation.at_joints(target.q_target, expected.reflectors.front().p_FS_mm));
    }
  };
  co_await run_compute_(job);

  std::vector<Target> reachable;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    std::string reason;
    if (!result_->improves) {
      reason = "the calibrated arm is no better than the nominal one on the validation poses";
    } else if (!(*solved)[i]) {
      reason = "compensated: " + described((*solved)[i].error(), nominal);
    }
    if (!reason.empty()) {
      Done skipped = co_await skip(targets[i], 0, reason);
      if (!skipped) co_return std::unexpected(skipped.error());
      continue;
    }
    targets[i].q_commanded = (*solved)[i]->q;
    reachable.push_back(targets[i]);
  }
  co_return reachable;
}

void Campaign::judge_remeasured() {
  const CalibratedCell& cell = result_->calibration.cell;
  // Where the nominal arm was asked to be, seen from the identified base.
  const CalibratedCell asked{config_.robot.model, cell.base, cell.reflectors};
  for (const StoredPoint& point : result_->points) {
    if (point.purpose != PointPurpose::Remeasure) continue;
    result_->remeasured_errors_mm.push_back(point.p_WS_mm - asked.predict(point.q_target, 0));
  }
  if (result_->remeasured_errors_mm.empty()) return;
  result_->remeasured = error_statistics(result_->remeasured_errors_mm);
}

void Campaign::pause() {
  paused_ = true;
  observer_.on_progress(progress_);
}

void Campaign::resume() {
  paused_ = false;
  if (resumed_) resumed_->cancel();
  observer_.on_progress(progress_);
}

void Campaign::abort(std::string reason) {
  if (aborting_) return;
  aborting_ = true;
  abort_reason_ = std::move(reason);
  cancel_.emit(asio::cancellation_type::terminal);
}

asio::awaitable<void> Campaign::wait_while_paused() {
  while (paused_) {
    resumed_->expires_at(asio::steady_timer::time_point::max());
    boost::system::error_code woken;
    auto token = asio::redirect_error(asio::use_awaitable, woken);
    co_await resumed_->async_wait(token);
  }
}

asio::awaitable<StoreResult<void>> Campaign::end_in_journal(std::optional<CampaignError> error) {
  if (!begun_) {
    auto begun = co_await journal_.begin(result_->identities);
    if (!begun) co_return begun;
  }
  std::shared_ptr<const CampaignResult> result;
  if (!error) result = result_;
  auto ended = co_await journal_.end(result, error);
  co_return ended;
}

void Campaign::enter(CampaignPhase phase) {
  progress_.phase = phase;
  error_sum_mm_ = 0;
  error_count_ = 0;
  observer_.on_progress(progress_);
}

void Campaign::count_error(double deviation_mm) {
  error_sum_mm_ += deviation_mm;
  progress_.error_mm = error_sum_mm_ / ++error_count_;
}

void Campaign::count_pose() {
  ++progress_.done;
  const std::chrono::duration<double> taken = clock_.now() - *first_pose_;
  progress_.time_left_s = taken.count() / progress_.done * (progress_.total - progress_.done);
}

}  // namespace truepose::daemon
