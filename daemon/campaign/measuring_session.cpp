#include "daemon/campaign/measuring_session.hpp"

#include <functional>
#include <utility>

#include "config/cell_setup.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using namespace std::chrono_literals;

namespace {

constexpr Duration kBeforeRetry = 1s;

/// A device's error that ends the campaign.
CampaignError fatal(const DeviceError& error) {
  return {.fault = error.remedy == Remedy::WrongArm ? CampaignFault::WrongArm : CampaignFault::Device,
          .detail = error.detail,
          .what_to_do = error.what_to_do};
}

/// What the tracker tells of it.
StoredPoint stored_point(const drivers::SmrPoint& measured) {
  StoredPoint point;
  point.p_WS_mm = measured.p_WS_mm;
  point.orientation = measured.orientation;
  point.std_mm = measured.std_mm;
  point.temperature_c = measured.temperature_c;
  point.pressure_mbar = measured.pressure_mbar;
  point.humidity_percent = measured.humidity_percent;
  return point;
}

}  // namespace

std::vector<std::int8_t> approach_direction(const MeasuringTarget& target, const RobotModel& robot) {
  const auto side = static_cast<std::int8_t>((target.way_rad > 0) - (target.way_rad < 0));
  return std::vector<std::int8_t>(robot.joints.size(), side);
}

MeasuringSession::MeasuringSession(const config::CellConfig& config, CampaignDevices devices,
                                   CampaignJournal& journal, CampaignObserver& observer, RunJob run_compute,
                                   std::shared_ptr<const CampaignPast> past)
    : CampaignRun{config, devices.clock, journal, observer, run_compute, past},
      devices_{
          config, devices, [&observer](const std::string& sentence) { observer.on_trouble(sentence); },
          [&observer](CellDevice device, const std::string& reason) { observer.on_waiting(device, reason); }},
      journal_{journal},
      motion_{config.robot.model, devices_, std::move(run_compute)},
      search_{config, devices_},
      past_{std::move(past)} {
  if (!past_) return;
  past_left_ = past_->outcomes();
  for (const PlannedPose& planned : past_->plan.poses) in_plan_.insert(planned.pose);
}

CampaignOutcome<void> MeasuringSession::connect(const CampaignNeeds& needs) {
  progress().enter(CampaignPhase::Connect);
  auto begun = co_await begin();
  if (!begun) co_return std::unexpected(store_failed(begun.error()));
  auto identities = co_await connected_devices(needs);
  if (!identities) co_return std::unexpected(fatal(identities.error()));
  result().identities = *std::move(identities);
  begun_ = true;
  if (const auto other = other_arm()) co_return std::unexpected(*other);
  Done known = co_await write(&CampaignJournal::know, result().identities);
  if (!known || !needs.moving_arm) co_return known;
  Done proven = co_await prove_arm();
  co_return proven;
}

/// A device that is away for a moment, or hangs up, does not end a campaign. A device that stays away is
/// reported before the arm has moved.
CellDevices::Outcome<Identities> MeasuringSession::connected_devices(const CampaignNeeds& needs) {
  const ArmProof proof = needs.moving_arm ? ArmProof::ByMotion : ArmProof::AsItStands;
  for (int tries_left = config().campaign.retries;; --tries_left) {
    auto identities = co_await devices_.connect(proof, needs.tracker);
    if (identities || identities.error().remedy == Remedy::WrongArm || tries_left == 0) co_return identities;
    observer().on_trouble(identities.error().detail + "; trying again");
    const TimePoint next = clock().now() + kBeforeRetry;
    co_await clock().sleep_until(next);
  }
}

/// In the journal.
asio::awaitable<StoreResult<void>> MeasuringSession::begin() {
  in_journal_ = true;
  auto begun = co_await journal_.begin(progress().counted().total);
  if (!begun) co_return std::unexpected(begun.error());
  if (past_) begin_resumption(*begun);
  co_return StoreResult<void>{};
}

CampaignOutcome<void> MeasuringSession::prove_arm() {
  for (int tries_left = config().campaign.retries;; --tries_left) {
    co_await pause().wait();
    auto proven = co_await devices_.prove_arm();
    if (proven) co_return Done{};
    if (proven.error().remedy == Remedy::Retry && tries_left == 0)
      co_return std::unexpected(fatal(proven.error()));
    observer().on_trouble("the first small motions: " + proven.error().detail);
    Done recovered = co_await recover(proven.error());
    if (!recovered) co_return recovered;
  }
}

asio::awaitable<StoreResult<void>> MeasuringSession::end(std::optional<CampaignError> error) {
  if (!in_journal_) {
    // What could not be begun is kept as a whole.
    auto begun = co_await begin();
    static_cast<void>(begun);
  }
  std::shared_ptr<const CampaignResult> result;
  if (!error) result = shared_result();
  auto ended = co_await journal_.end(result, error);
  co_return ended;
}

CampaignOutcome<void> MeasuringSession::plan(CalibratedCell cell, PlanOptions options,
                                             Reflectors reflectors) {
  progress().enter(CampaignPhase::Plan);
  options.sizes.clear();
  options.random_sets = 0;
  auto here = co_await devices_.position();
  if (here) options.start = *here;
  Scene scene = config::scene_of(config());
  scene.shows_last_axis = !options.by_orientation;
  if (reflectors == Reflectors::First) scene.sight.further.clear();
  search_.look_for(reflectors);
  const auto earlier = past_ ? past_->earlier_plan() : std::nullopt;
  auto job = [cell, scene, options, earlier] {
    return earlier ? PoseSupply::again(cell, scene, options, *earlier)
                   : PoseSupply::make(cell, scene, options);
  };
  auto made = co_await compute(job);
  if (!made) co_return std::unexpected(CampaignError{CampaignFault::Planning, made.error()});
  poses_ = std::make_shared<PoseSupply>(*std::move(made));
  motion_.use_paths_of(poses_);
  co_return Done{};
}

MeasuringTarget MeasuringSession::new_target(PointPurpose purpose, const JointVector& q,
                                             Replacement replacement) {
  const int pose = next_number_++;
  return {.pose = pose,
          .purpose = purpose,
          .q_target = q,
          .q_commanded = q,
          .replacement = replacement,
          .way_rad = approach_way_rad(config().campaign, pose),
          .q_from = {}};
}

MeasuringTarget MeasuringSession::again(MeasuringTarget target) {
  target.pose = next_number_++;
  return target;
}

CampaignOutcome<void> MeasuringSession::keep_plan(std::vector<MeasuringTarget> targets) {
  std::vector<PlannedPose> fresh;
  for (const MeasuringTarget& target : targets)
    if (in_plan_.insert(target.pose).second)
      fresh.push_back({target.pose, target.purpose, target.q_target, target.q_commanded, target.replaces});
  if (fresh.empty()) co_return Done{};
  Done kept = co_await write(&CampaignJournal::add_planned, fresh, progress().counted().total);
  co_return kept;
}

void MeasuringSession::expect(CalibratedCell cell, double reach) { search_.expect(std::move(cell), reach); }

CampaignOutcome<void> MeasuringSession::visit(JointVector q) {
  co_await pause().wait();
  auto reached = co_await motion_.drive(q);
  if (reached) co_return Done{};
  Done recovered = co_await recover(reached.error());
  co_return recovered;
}

CampaignOutcome<std::vector<MeasuringTarget>> MeasuringSession::measure_all(
    std::vector<MeasuringTarget> targets, std::function<CampaignOutcome<void>()> after_each) {
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

CampaignOutcome<std::optional<StoredPoint>> MeasuringSession::measure(MeasuringTarget target) {
  if (past_) {
    if (const auto wrong = contradiction(target)) co_return std::unexpected(*wrong);
    if (const auto before = taken_before(target)) co_return before->point;
    Done resumed = co_await resume_from_past();
    if (!resumed) co_return std::unexpected(resumed.error());
    // Compensated joints stay those of the model that was found first.
    if (const PlannedPose* planned = past_->planned(target.pose);
        planned && target.purpose == PointPurpose::Remeasure)
      target.q_commanded = planned->q_commanded;
  }
  const std::vector<MeasuringTarget> this_one{target};
  Done planned = co_await keep_plan(this_one);
  if (!planned) co_return std::unexpected(planned.error());
  co_await pause().wait();
  progress().begin_pose();
  const int attempts = 1 + config().campaign.retries;
  int tried = 0;
  bool again = false;
  DeviceError error{Remedy::Retry, ""};
  do {
    co_await pause().wait();
    for (int n = 1; n <= attempts; ++n, ++tried) {
      auto points = co_await attempt(target);
      if (points) {
        lost_in_row_ = last_lost_ = 0;
        auto kept = co_await keep(*std::move(points));
        if (!kept) co_return std::unexpected(kept.error());
        co_return in_first_frame(*kept);
      }
      error = points.error();
      observer().on_trouble("pose " + std::to_string(target.pose) + ", attempt " + std::to_string(n) +
                            " of " + std::to_string(attempts) + ": " + error.detail);
      Done recovered = co_await recover(error);
      if (!recovered) co_return std::unexpected(recovered.error());
    }
    again = co_await pause_for_losses(target, error);
  } while (again);
  Done skipped = co_await skip(target, tried, error.detail);
  if (!skipped) co_return std::unexpected(skipped.error());
  co_return std::nullopt;
}

// One pose may hide the reflector; several in a row are a cause that stays. Where the beam is interrupted
// that is a person in the cell, or something that was put there: that the beam is back does not mean that the
// person who broke it has left. So the arm stands still from then on, and continues when a person says so.
asio::awaitable<bool> MeasuringSession::pause_for_losses(MeasuringTarget target, DeviceError error) {
  if (std::exchange(last_lost_, target.pose) == target.pose) co_return false;
  const int most = config().campaign.pause_after_lost;
  if (++lost_in_row_ < most || most == 0) co_return false;
  const std::string remedy = error.beam_lost ? "see that the cell is empty and that nothing stands between "
                                               "tracker and reflector"
                             : error.what_to_do.empty() ? "remove the cause"
                                                        : error.what_to_do;
  co_await pause().wait_for_operator(
      "paused: " + std::to_string(lost_in_row_) + " poses in a row could not be measured, pose " +
      std::to_string(target.pose) + " last: " + error.detail + "; " + remedy + ", then resume the campaign");
  co_return true;
}

/// What to measure in place of a pose that failed. Never more than were measured, so that a device that
/// always fails does not make the campaign endless.
CampaignOutcome<std::optional<MeasuringTarget>> MeasuringSession::substitute(MeasuringTarget failed) {
  if (failed.replacement == Replacement::None || substitutes_ >= progress().counted().done)
    co_return std::nullopt;
  const bool informative = failed.replacement == Replacement::Informative;
  if (const PlannedPose* before = past_ ? past_->substitute_of(failed.pose) : nullptr) {
    poses_->replaced(failed.q_target, before->q_target);
    co_return new_substitute(failed, before->q_target);
  }
  auto job = [poses = poses_, q = failed.q_target, informative] {
    return informative ? poses->substitute(q) : poses->validation_substitute(q);
  };
  auto other = co_await compute(job);
  if (!other) co_return std::nullopt;
  const MeasuringTarget target = new_substitute(failed, *other);
  observer().on_trouble("pose " + std::to_string(failed.pose) + " is replaced by pose " +
                        std::to_string(target.pose));
  co_return target;
}

MeasuringTarget MeasuringSession::new_substitute(const MeasuringTarget& failed, const JointVector& q) {
  ++substitutes_;
  progress().add_to_total(1);
  MeasuringTarget target = new_target(failed.purpose, q, failed.replacement);
  target.replaces = failed.pose;
  return target;
}

CellDevices::Outcome<JointVector> MeasuringSession::reach(MeasuringTarget target) {
  if (target.q_from.size() > 0) {
    auto start = co_await motion_.drive(target.q_from);
    if (!start) co_return std::unexpected(start.error());
    target.way_rad = 0;
  }
  auto reached = co_await motion_.arrive(target.q_commanded, target.way_rad);
  co_return reached;
}

bool MeasuringSession::in_two_faces(int pose) const {
  const int every = config().campaign.two_face_every;
  return every > 0 && pose % every == 0;
}

/// Of what was measured there.
StoredPoint MeasuringSession::point_at(const MeasuringTarget& target, const JointVector& reached,
                                       const drivers::SmrPoint& measured, const std::string& smr) const {
  StoredPoint point = stored_point(measured);
  point.pose = target.pose;
  point.purpose = target.purpose;
  point.q_target = target.q_target;
  point.q_commanded = target.q_commanded;
  point.q_actual = reached;
  point.direction = motion_.direction();
  point.smr = smr;
  return point;
}

CellDevices::Outcome<MeasuringSession::Points> MeasuringSession::attempt(MeasuringTarget target) {
  auto reached = co_await reach(target);
  if (!reached) co_return std::unexpected(reached.error());
  ReflectorSearch::ArmPosture posture{.q = *reached,
                                      .direction = motion_.direction(),
                                      .purpose = target.purpose,
                                      .readings = target.readings,
                                      .two_face = in_two_faces(target.pose)};
  auto seen = co_await search_.measure(std::move(posture));
  if (!seen) co_return std::unexpected(seen.error());
  for (const std::string& sentence : seen->missed)
    observer().on_trouble("pose " + std::to_string(target.pose) + ": " + sentence);
  Points points;
  for (const ReflectorSearch::ReflectorResult& found : seen->found) {
    const std::string& smr = search_.name(found.reflector);
    // First, so that a point that is there is known to have been seen in both faces.
    if (found.measured.face1)
      points.emplace_back(point_at(target, *reached, *found.measured.face1, smr)).purpose =
          PointPurpose::Face1;
    points.push_back(point_at(target, *reached, found.measured.point, smr));
  }
  co_return points;
}

CampaignOutcome<StoredPoint> MeasuringSession::store(StoredPoint point) {
  point.resumption = static_cast<int>(result().resumptions.size());
  auto stored = co_await write(&CampaignJournal::add_point, point);
  if (!stored) co_return std::unexpected(stored.error());
  result().points.push_back(*stored);
  co_return *std::move(stored);
}

CampaignOutcome<StoredPoint> MeasuringSession::keep(Points points) {
  Points kept;
  for (StoredPoint& point : points) {
    auto stored = co_await store(std::move(point));
    if (!stored) co_return std::unexpected(stored.error());
    if (stored->purpose != PointPurpose::Face1) kept.push_back(*std::move(stored));
  }
  progress().count_done();
  progress().end_pose();
  for (const StoredPoint& point : kept) {
    const double deviation_mm = count_deviation(point);
    observer().on_point(point, deviation_mm, progress().now());
  }
  co_return kept.front();
}

/// @return how far it is from where it was expected
double MeasuringSession::count_deviation(const StoredPoint& point) {
  const double deviation_mm = (*in_first_frame(point).p_WS_mm - search_.predicted_mm(point)).norm();
  if (search_.placement_known()) progress().count_error(deviation_mm);
  return deviation_mm;
}

CampaignOutcome<std::optional<StoredPoint>> MeasuringSession::measure_fixed(FixedReflector what,
                                                                            Eigen::Vector3d p_W_mm,
                                                                            double search_mm) {
  if (past_) {
    if (auto before = measured_before(what.number, what.purpose, what.name)) co_return before;
    if (past_left_ > 0) co_return std::nullopt;  // it was not seen then
    Done resumed = co_await resume_from_past();
    if (!resumed) co_return std::unexpected(resumed.error());
  }
  for (int n = 0; n <= config().campaign.retries; ++n) {
    co_await pause().wait();
    CellDevices::MeasureRequest request{.p_W_mm = now(p_W_mm), .search_mm = search_mm, .gate_mm = search_mm};
    auto point = co_await attempt_fixed(request);
    if (point) {
      point->pose = what.number;
      point->smr = what.name;
      point->purpose = what.purpose;
      auto stored = co_await store(*std::move(point));
      if (!stored) co_return std::unexpected(stored.error());
      if (is_pose(what.purpose)) {
        progress().count_done();
        observer().on_point(*stored, (*in_first_frame(*stored).p_WS_mm - p_W_mm).norm(), progress().now());
      }
      co_return in_first_frame(*stored);
    }
    observer().on_trouble(what.name + ": " + point.error().detail);
    Done recovered = co_await recover(point.error());
    if (!recovered) co_return std::unexpected(recovered.error());
  }
  co_return std::nullopt;
}

/// Does not move the arm; its joints are stored with the point.
CellDevices::Outcome<StoredPoint> MeasuringSession::attempt_fixed(CellDevices::MeasureRequest request) {
  auto q = co_await devices_.position();
  if (!q) co_return std::unexpected(q.error());
  auto measured = co_await devices_.measure(request);
  if (!measured) co_return std::unexpected(measured.error());
  StoredPoint point = stored_point(measured->point);
  point.purpose = PointPurpose::Nest;
  point.q_target = point.q_commanded = point.q_actual = *q;
  co_return point;
}

CampaignOutcome<void> MeasuringSession::skip(MeasuringTarget target, int attempts, std::string reason) {
  if (skipped_before(target.pose)) co_return Done{};
  const SkippedPose skipped{target.pose, attempts, reason};
  Done stored = co_await write(&CampaignJournal::add_skipped, skipped);
  if (!stored) co_return stored;
  result().skipped.push_back(skipped);
  progress().count_skipped();
  progress().end_pose();
  StoredPoint wanted;
  wanted.pose = target.pose;
  wanted.purpose = target.purpose;
  wanted.smr = search_.names_at(target.q_commanded, target.purpose);
  observer().on_skipped(wanted, reason, progress().now());
  co_return Done{};
}

/// After a failed attempt: whatever lets the next one succeed. Fails where there is to be no next one.
CampaignOutcome<void> MeasuringSession::recover(DeviceError error) {
  if (error.remedy == Remedy::WrongArm) co_return std::unexpected(fatal(error));
  if (error.remedy == Remedy::Retry) {
    const TimePoint next = clock().now() + kBeforeRetry;
    co_await clock().sleep_until(next);
    co_return Done{};
  }
  auto recovered = co_await devices_.recover(std::move(error));
  if (!recovered) co_return std::unexpected(fatal(recovered.error()));
  co_return Done{};
}

asio::awaitable<void> MeasuringSession::wait_for_operator(std::string sentence) {
  if (past_left_ == 0) co_await pause().wait_for_operator(std::move(sentence));
}

}  // namespace truepose::daemon
