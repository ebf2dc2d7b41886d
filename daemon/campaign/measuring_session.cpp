#include "daemon/campaign/measuring_session.hpp"

#include <utility>

#include "config/cell_setup.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using namespace std::chrono_literals;

namespace {

constexpr Duration kBeforeRetry = 1s;

using Done = std::expected<void, CampaignError>;

/// A device's error that ends the campaign.
CampaignError fatal(const DeviceError& error) {
  return {error.remedy == Remedy::WrongArm ? CampaignFault::WrongArm : CampaignFault::Device, error.detail};
}

CampaignError store_failed(const StoreError& error) { return {CampaignFault::Store, error.detail}; }

}  // namespace

std::vector<std::int8_t> approach_direction(const MeasuringTarget& target, const RobotModel& robot) {
  const auto side = static_cast<std::int8_t>((target.way_rad > 0) - (target.way_rad < 0));
  return std::vector<std::int8_t>(robot.joints.size(), side);
}

MeasuringSession::MeasuringSession(const config::CellConfig& config, CampaignDevices devices,
                                   CampaignJournal& journal, CampaignObserver& observer, RunJob run_compute)
    : config_{config},
      devices_{
          config_, devices, [&observer](const std::string& sentence) { observer.on_trouble(sentence); },
          [&observer](CellDevice device, const std::string& reason) { observer.on_waiting(device, reason); }},
      clock_{devices.clock},
      journal_{journal},
      observer_{observer},
      run_compute_{std::move(run_compute)},
      motion_{config_.robot.model, devices_, run_compute_},
      expected_{config::rough_cell(config_)} {}

MeasuringSession::Outcome<void> MeasuringSession::connect() {
  enter(CampaignPhase::Connect);
  auto identities = co_await devices_.connect();
  if (!identities) co_return std::unexpected(fatal(identities.error()));
  result_->identities = *std::move(identities);
  begun_ = true;
  auto begun = co_await journal_.begin(result_->identities);
  if (!begun) co_return std::unexpected(store_failed(begun.error()));
  co_return Done{};
}

asio::awaitable<StoreResult<void>> MeasuringSession::end(std::optional<CampaignError> error) {
  if (!begun_) {
    auto begun = co_await journal_.begin(result_->identities);
    if (!begun) co_return begun;
  }
  std::shared_ptr<const CampaignResult> result;
  if (!error) result = result_;
  auto ended = co_await journal_.end(result, error);
  co_return ended;
}

MeasuringSession::Outcome<void> MeasuringSession::plan(CalibratedCell cell, PlanOptions options) {
  enter(CampaignPhase::Plan);
  options.sizes.clear();
  options.random_sets = 0;
  auto here = co_await devices_.position();
  if (here) options.start = *here;
  auto job = [cell, scene = config::scene_of(config_), options] {
    return PoseSupply::make(cell, scene, options);
  };
  auto made = co_await compute(job);
  if (!made) co_return std::unexpected(CampaignError{CampaignFault::Planning, made.error()});
  poses_ = std::make_shared<PoseSupply>(*std::move(made));
  motion_.use_ways_of(poses_);
  co_return Done{};
}

MeasuringTarget MeasuringSession::new_target(PointPurpose purpose, const JointVector& q,
                                             Replacement replacement) {
  const int pose = next_number_++;
  return {pose, purpose, q, q, replacement, approach_way_rad(config_.campaign, pose), {}};
}

MeasuringTarget MeasuringSession::again(MeasuringTarget target) {
  target.pose = next_number_++;
  return target;
}

void MeasuringSession::expect(CalibratedCell cell, double reach) {
  expected_ = std::move(cell);
  reach_ = reach;
  placement_known_ = true;
}

MeasuringSession::Outcome<void> MeasuringSession::visit(JointVector q) {
  co_await wait_while_paused();
  auto reached = co_await motion_.drive(q);
  if (reached) co_return Done{};
  Done recovered = co_await recover(reached.error());
  co_return recovered;
}

MeasuringSession::Outcome<std::vector<MeasuringTarget>> MeasuringSession::measure_all(
    std::vector<MeasuringTarget> targets, std::function<Outcome<void>()> after_each) {
  for (std::size_t i = 0; i < targets.size();) {
    auto point = co_await measure(targets[i]);
    if (!point) co_return std::unexpected(point.error());
    if (!*point) {
      auto other = co_await substitute(targets[i]);
      if (!other) co_return std::unexpected(other.error());
      if (*other) {
        targets[i] = **other;
        continue;
      }
    }
    if (after_each) {
      Done done = co_await after_each();
      if (!done) co_return std::unexpected(done.error());
    }
    ++i;
  }
  co_return targets;
}

MeasuringSession::Outcome<std::optional<StoredPoint>> MeasuringSession::measure(MeasuringTarget target) {
  co_await wait_while_paused();
  if (!first_pose_) first_pose_ = clock_.now();
  const int attempts = 1 + config_.campaign.retries;
  int tried = 0;
  DeviceError error{Remedy::Retry, ""};
  do {
    co_await wait_while_paused();
    for (int n = 1; n <= attempts; ++n, ++tried) {
      auto point = co_await attempt(target);
      if (point) {
        beamless_.reset();
        Done kept = co_await keep(*point);
        if (!kept) co_return std::unexpected(kept.error());
        co_return *point;
      }
      error = point.error();
      observer_.on_trouble("pose " + std::to_string(target.pose) + ", attempt " + std::to_string(n) + " of " +
                           std::to_string(attempts) + ": " + error.detail);
      Done recovered = co_await recover(error);
      if (!recovered) co_return std::unexpected(recovered.error());
    }
  } while (pause_for_beam(target, error));
  Done skipped = co_await skip(target, tried, error.detail);
  if (!skipped) co_return std::unexpected(skipped.error());
  co_return std::nullopt;
}

// One pose without a beam may hide the reflector; two in a row are a beam that is interrupted, and that is
// somebody in the cell, or something that was put there. So the arm stands still from then on, and goes on
// when a person says so: that the beam is back does not tell that the person who broke it has left.
bool MeasuringSession::pause_for_beam(const MeasuringTarget& target, const DeviceError& error) {
  if (!error.beam_lost) {
    beamless_.reset();
    return false;
  }
  const std::optional<int> before = std::exchange(beamless_, target.pose);
  if (!before || *before == target.pose) return false;
  paused_ = true;
  observer_.on_paused(
      "paused: the beam was lost at two poses in a row, " + std::to_string(*before) + " and " +
      std::to_string(target.pose) +
      "; see that nobody is in the cell and that nothing stands between tracker and reflector, "
      "then resume the campaign");
  observer_.on_progress(progress_);
  return true;
}

/// What to measure in place of a pose that failed. Never more than were measured, so that a device that
/// always fails does not make the campaign endless.
MeasuringSession::Outcome<std::optional<MeasuringTarget>> MeasuringSession::substitute(
    MeasuringTarget failed) {
  if (failed.replacement == Replacement::None || substitutes_ >= static_cast<int>(result_->points.size()))
    co_return std::nullopt;
  const bool informative = failed.replacement == Replacement::Informative;
  auto job = [poses = poses_, q = failed.q_target, informative] {
    return informative ? poses->substitute(q) : poses->validation_substitute(q);
  };
  auto other = co_await compute(job);
  if (!other) co_return std::nullopt;
  ++substitutes_;
  ++progress_.total;
  const MeasuringTarget target = new_target(failed.purpose, *other, failed.replacement);
  observer_.on_trouble("pose " + std::to_string(failed.pose) + " is replaced by pose " +
                       std::to_string(target.pose));
  co_return target;
}

CellDevices::Outcome<StoredPoint> MeasuringSession::attempt(MeasuringTarget target) {
  if (target.q_from.size() > 0) {
    auto start = co_await motion_.drive(target.q_from);
    if (!start) co_return std::unexpected(start.error());
    target.way_rad = 0;
  }
  auto reached = co_await motion_.arrive(target.q_commanded, target.way_rad);
  if (!reached) co_return std::unexpected(reached.error());
  const config::TrackerConfig& tracker = config_.tracker;
  const Eigen::Vector3d p_WS_mm = expected_.predict(*reached, 0, motion_.direction());
  const double search_mm = placement_known_ ? reach_ * tracker.search_mm : tracker.search_first_mm;
  const double gate_mm = placement_known_ ? reach_ * tracker.gate_mm : tracker.search_first_mm;
  auto measured = co_await devices_.measure(p_WS_mm, search_mm, gate_mm, target.readings);
  if (!measured) co_return std::unexpected(measured.error());

  StoredPoint point;
  point.pose = target.pose;
  point.purpose = target.purpose;
  point.q_target = target.q_target;
  point.q_commanded = target.q_commanded;
  point.q_actual = *reached;
  point.direction = motion_.direction();
  point.smr = config_.reflector.name;
  point.p_WS_mm = measured->p_WS_mm;
  point.std_mm = measured->std_mm;
  point.temperature_c = measured->temperature_c;
  point.pressure_mbar = measured->pressure_mbar;
  point.humidity_percent = measured->humidity_percent;
  co_return point;
}

/// On the disk first: what the arm moves on from is never lost.
MeasuringSession::Outcome<void> MeasuringSession::keep(StoredPoint point) {
  auto stored = co_await journal_.add_point(point);
  if (!stored) co_return std::unexpected(store_failed(stored.error()));
  point = *std::move(stored);
  result_->points.push_back(point);
  const double deviation_mm = (point.p_WS_mm - expected_.predict(point.q_actual, 0, point.direction)).norm();
  if (placement_known_) count_error(deviation_mm);
  count_pose();
  observer_.on_point(point, deviation_mm, progress_);
  co_return Done{};
}

MeasuringSession::Outcome<void> MeasuringSession::skip(MeasuringTarget target, int attempts,
                                                       std::string reason) {
  if (!first_pose_) first_pose_ = clock_.now();
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
MeasuringSession::Outcome<void> MeasuringSession::recover(DeviceError error) {
  if (error.remedy == Remedy::GiveUp || error.remedy == Remedy::WrongArm)
    co_return std::unexpected(fatal(error));
  if (error.remedy == Remedy::Retry) {
    const TimePoint next = clock_.now() + kBeforeRetry;
    co_await clock_.sleep_until(next);
    co_return Done{};
  }
  auto recovered = co_await devices_.recover(std::move(error));
  if (!recovered) co_return std::unexpected(fatal(recovered.error()));
  co_return Done{};
}

void MeasuringSession::pause() {
  paused_ = true;
  observer_.on_progress(progress_);
}

void MeasuringSession::resume() {
  paused_ = false;
  resumed_.notify();
  observer_.on_progress(progress_);
}

asio::awaitable<void> MeasuringSession::wait_while_paused() {
  while (paused_) co_await resumed_.wait();
}

void MeasuringSession::enter(CampaignPhase phase) {
  progress_.phase = phase;
  error_sum_mm_ = 0;
  error_count_ = 0;
  observer_.on_progress(progress_);
}

void MeasuringSession::count_error(double deviation_mm) {
  error_sum_mm_ += deviation_mm;
  progress_.error_mm = error_sum_mm_ / ++error_count_;
}

void MeasuringSession::count_pose() {
  ++progress_.done;
  const std::chrono::duration<double> taken = clock_.now() - *first_pose_;
  progress_.time_left_s = taken.count() / progress_.done * (progress_.total - progress_.done);
}

}  // namespace truepose::daemon
