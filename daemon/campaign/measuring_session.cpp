#include "daemon/campaign/measuring_session.hpp"

#include <utility>

#include "core/planted_bug.hpp"
#include "daemon/campaign/arm_check.hpp"
#include "daemon/campaign/interruption_check.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;

namespace {

/// Until the arm is connected it may not be known which it is.
Done check_model(const std::string& serial, const std::string& here) {
  if (serial.empty() || planted("a model works on any arm that connects")) return {};
  std::string other = other_arm("the active model", serial, here);
  if (other.empty()) return {};
  return std::unexpected(CampaignError{.fault = CampaignFault::WrongArm,
                                       .detail = std::move(other),
                                       .what_to_do = std::string{kNeedsModelOfTheArm}});
}

}  // namespace

MeasuringSession::MeasuringSession(const config::CellConfig& config, CampaignDevices devices,
                                   CampaignJournal& journal, CampaignObserver& observer, RunJob run_compute,
                                   std::shared_ptr<const CampaignPast> past)
    : CampaignRun{config, devices.clock, journal, observer, run_compute, past},
      journal_{journal},
      devices_{*this, devices, std::move(run_compute)},
      plan_{*this, devices_, past},
      past_{*this, std::move(past)} {}

CampaignOutcome<void> MeasuringSession::connect(CampaignNeeds needs, std::string model_serial) {
  progress().enter(CampaignPhase::Connect);
  auto begun = co_await begin();
  if (!begun) co_return std::unexpected(store_failed(begun.error()));
  auto identities = co_await devices_.connect(needs);
  if (!identities) co_return std::unexpected(identities.error());
  result().identities = *std::move(identities);
  begun_ = true;
  Done done = past_.check_arm();
  if (done) done = check_model(model_serial, result().identities.robot.serial);
  if (done) done = co_await write(&CampaignJournal::know, result().identities);
  if (done && needs.moving_arm) done = co_await devices_.prove_arm();
  co_return done;
}

/// In the journal.
asio::awaitable<StoreResult<void>> MeasuringSession::begin() {
  in_journal_ = true;
  auto begun = co_await journal_.begin(progress().counted().total);
  if (!begun) co_return std::unexpected(begun.error());
  past_.begin(*begun);
  search().set_tracker_shift(X_now_first());
  co_return StoreResult<void>{};
}

asio::awaitable<StoreResult<void>> MeasuringSession::end(std::optional<CampaignError> error) {
  if (!in_journal_) {
    // What could not be begun is kept as a whole.
    auto begun = co_await begin();
    static_cast<void>(begun);
  }
  std::shared_ptr<const CampaignResult> result;
  if (!error) result = shared_result();
  co_return co_await journal_.end(result, error);
}

asio::awaitable<void> MeasuringSession::wait_for_operator(std::string sentence) {
  if (!past_.has_more()) co_await pause().wait_for_operator(std::move(sentence));
}

/// Before the first step that was not taken yet.
CampaignOutcome<void> MeasuringSession::resume_from_past() {
  if (!past_.resumes() || past_.has_resumed()) co_return Done{};
  const CampaignPhase phase = progress().counted().phase;
  Done done;
  if (before_resuming_) done = co_await before_resuming_();
  if (done) done = co_await find_what_moved(*this);
  if (!done) co_return done;
  search().set_tracker_shift(X_now_first());
  done = co_await past_.note_resumption();
  if (done) progress().enter(phase);
  co_return done;
}

CampaignOutcome<void> MeasuringSession::visit(JointVector q) {
  co_await pause().wait();
  auto reached = co_await devices_.motion().drive(q);
  if (reached) co_return Done{};
  co_return co_await devices_.recover(reached.error());
}

CampaignOutcome<void> MeasuringSession::measure_all(std::vector<MeasuringTarget>& targets,
                                                    std::function<CampaignOutcome<void>()> after_each) {
  for (std::size_t i = 0; i < targets.size();) {
    auto point = co_await measure(targets[i]);
    if (!point) co_return std::unexpected(point.error());
    if (!*point) {
      auto other = co_await plan_.substitute(targets[i]);
      if (!other) co_return std::unexpected(other.error());
      if (*other) {
        targets[i] = **other;
        continue;
      }
    }
    if (after_each) {
      Done done = co_await after_each();
      if (!done) co_return done;
    }
    ++i;
  }
  co_return Done{};
}

CampaignOutcome<std::optional<StoredPoint>> MeasuringSession::measure(MeasuringTarget target) {
  const auto before = past_.take(target);
  if (!before) co_return std::unexpected(before.error());
  if (*before) {
    for (const StoredPoint& point : **before) count_deviation(point);
    if ((*before)->empty()) co_return std::nullopt;
    co_return in_first_frame((*before)->front());
  }
  Done ready = co_await resume_from_past();
  if (!ready) co_return std::unexpected(ready.error());
  target.q_commanded = past_.commanded(target);
  const std::vector<MeasuringTarget> this_one{target};
  ready = co_await plan_.keep(this_one);
  if (!ready) co_return std::unexpected(ready.error());
  co_await pause().wait();
  progress().begin_pose();
  const int attempts = 1 + config().campaign.retries;
  int tried = 0;
  bool again = false;
  DeviceError error{Remedy::Retry, ""};
  do {
    co_await pause().wait();
    for (int n = 1; n <= attempts; ++n, ++tried) {
      auto points = co_await devices_.read(target);
      if (points) {
        lost_in_row_ = last_lost_ = 0;
        auto kept = co_await keep(*std::move(points));
        if (!kept) co_return std::unexpected(kept.error());
        co_return in_first_frame(*kept);
      }
      error = points.error();
      observer().on_trouble("pose " + std::to_string(target.pose) + ", attempt " + std::to_string(n) +
                            " of " + std::to_string(attempts) + ": " + error.detail);
      Done recovered = co_await devices_.recover(error);
      if (!recovered) co_return std::unexpected(recovered.error());
    }
    again = co_await pause_for_losses(target, error);
  } while (again);
  Done skipped = co_await skip(target, tried, error.detail);
  if (!skipped) co_return std::unexpected(skipped.error());
  co_return std::nullopt;
}

/// After the last attempt at a pose, which failed by `error`: pauses where so many in a row were lost.
/// @return whether it did, and the pose is to be tried again
//
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

CampaignOutcome<void> MeasuringSession::skip(MeasuringTarget target, int attempts, std::string reason) {
  if (past_.take_skipped(target.pose)) co_return Done{};
  const SkippedPose skipped{target.pose, attempts, reason};
  Done stored = co_await write(&CampaignJournal::add_skipped, skipped);
  if (!stored) co_return stored;
  result().skipped.push_back(skipped);
  progress().count_skipped();
  progress().end_pose();
  const std::string smr = search().names_at(target.q_commanded, target.purpose);
  const StoredPoint wanted{.pose = target.pose, .purpose = target.purpose, .smr = smr};
  observer().on_skipped(wanted, reason, progress().now());
  co_return Done{};
}

CampaignOutcome<std::optional<StoredPoint>> MeasuringSession::measure_fixed(FixedReflector what,
                                                                            Eigen::Vector3d p_W_mm,
                                                                            double search_mm) {
  const Points before = past_.take_points(what.number, what.purpose, what.name);
  if (!before.empty()) co_return in_first_frame(before.front());
  if (past_.has_more()) co_return std::nullopt;  // it was not seen then
  Done resumed = co_await resume_from_past();
  if (!resumed) co_return std::unexpected(resumed.error());
  const CellDevices::MeasureRequest request{
      .p_W_mm = X_now_first() * p_W_mm, .search_mm = search_mm, .gate_mm = search_mm};
  const Attempt attempt = [&] { return devices_.read_fixed(what, request); };
  auto stored = co_await store_first(what.name, attempt);
  if (!stored || !*stored) co_return stored;
  const StoredPoint seen = in_first_frame(**stored);
  if (is_pose(what.purpose)) {
    progress().count_done();
    observer().on_point(**stored, (*seen.p_WS_mm - p_W_mm).norm(), progress().now());
  }
  co_return seen;
}

CampaignOutcome<std::optional<Eigen::Vector3d>> MeasuringSession::measure_again(StoredPoint before,
                                                                                Eigen::Vector3d p_W_mm) {
  const bool is_nest = before.purpose == PointPurpose::Nest;
  const std::string name = is_nest ? before.smr : "pose " + std::to_string(before.pose);
  const Attempt attempt = [&] { return devices_.read_again(before, p_W_mm); };
  auto seen = co_await store_first(name + ", measured again", attempt);
  if (!seen) co_return std::unexpected(seen.error());
  if (!*seen) co_return std::nullopt;
  co_return (*seen)->p_WS_mm;
}

CampaignOutcome<void> MeasuringSession::touch(int number, std::string point, std::string request) {
  const auto before = past_.take_touch(number, point);
  if (!before) co_return std::unexpected(before.error());
  if (*before) co_return Done{};
  Done resumed = co_await resume_from_past();
  if (!resumed) co_return resumed;
  StoredPoint touched{.pose = number, .purpose = PointPurpose::Frame, .smr = point};
  for (std::string sentence = request;;) {
    co_await wait_for_operator(sentence);
    auto q = co_await jogged_to();
    if (q) {
      touched.q_actual = *std::move(q);
      break;
    }
    sentence = q.error().detail + ": " + request;
  }
  auto stored = co_await store(std::move(touched));
  if (!stored) co_return std::unexpected(stored.error());
  progress().count_done();
  observer().on_point(*stored, 0, progress().now());
  co_return Done{};
}

/// Who resumes twice has not touched twice.
CellDevices::Outcome<JointVector> MeasuringSession::jogged_to() {
  auto q = co_await devices().standstill();
  if (!q || result().points.empty()) co_return q;
  const StoredPoint& before = result().points.back();
  if (!CellDevices::has_stayed(*q, before.q_actual)) co_return q;
  co_return std::unexpected(DeviceError{
      Remedy::Retry, "robot: the arm has not been moved since it touched point \"" + before.smr + "\""});
}

/// @return the first of them
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

/// Of an attempt that succeeds. @return nothing where none did, which is reported
CampaignOutcome<std::optional<StoredPoint>> MeasuringSession::store_first(std::string name, Attempt attempt) {
  for (int n = 0; n <= config().campaign.retries; ++n) {
    co_await pause().wait();
    auto point = co_await attempt();
    if (point) co_return co_await store(*std::move(point));
    observer().on_trouble(name + ": " + point.error().detail);
    Done recovered = co_await devices_.recover(point.error());
    if (!recovered) co_return std::unexpected(recovered.error());
  }
  co_return std::nullopt;
}

/// On the disk first: what the arm moves on from is never lost.
CampaignOutcome<StoredPoint> MeasuringSession::store(StoredPoint point) {
  point.resumption = static_cast<int>(result().resumptions.size());
  auto stored = co_await write(&CampaignJournal::add_point, point);
  if (stored) result().points.push_back(*stored);
  co_return stored;
}

/// @return how far it is from where it was expected
double MeasuringSession::count_deviation(const StoredPoint& point) {
  const double deviation_mm = (*in_first_frame(point).p_WS_mm - search().predicted_mm(point)).norm();
  if (search().placement_known()) progress().count_error(deviation_mm);
  return deviation_mm;
}

}  // namespace truepose::daemon
