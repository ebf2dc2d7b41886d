#include "tests/soak/campaign_soak.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <expected>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/math/random.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/cell/cell_state.hpp"
#include "drivers/mock/mock_robot.hpp"
#include "drivers/mock/mock_tracker.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "drivers/plausible_point.hpp"
#include "tests/daemon/example_cell.hpp"
#include "tests/soak/event_hash.hpp"

namespace truepose::soak {

namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using daemon::TimePoint;

constexpr double kLargestCorrection_rad = 0.35;
constexpr double kSixSigma_mm = 6 * 0.01 * 1.8;
constexpr char kNoCompute[] = "the computation was given up: not enough memory";

/// Whether the model is put to use without anybody having looked at it.
bool activates(const daemon::CampaignResult& result) {
  return !result.as<daemon::CalibrationResult>().verdict.failed();
}

/// What is wrong with the tracker's data in one campaign.
struct BadData {
  int pushed_after = std::numeric_limits<int>::max();  ///< so many points
  Eigen::Vector3d pushed_by_mm{0, 0, 0};
  double loose_share = 0;  ///< of the points, which scatter by 3 mm, as the tracker itself says
  double odd_share = 0;    ///< whose standard deviations or weather are none
  bool is_biased() const { return pushed_by_mm != Eigen::Vector3d::Zero(); }
};

/// Spoils measurements, and remembers the last one that did not fail.
class WatchedTracker final : public drivers::Tracker {
 public:
  explicit WatchedTracker(drivers::Tracker& tracker) : tracker_{tracker} {}

  void spoil(const BadData& bad, std::uint64_t seed) {
    bad_ = bad;
    random_ = Random{seed};
    points_ = 0;
    offset_mm.setZero();
  }

  asio::awaitable<std::expected<drivers::TrackerIdentity, drivers::TrackerError>> connect(
      TimePoint deadline) override {
    return tracker_.connect(deadline);
  }
  asio::awaitable<std::expected<void, drivers::TrackerError>> aim(Eigen::Vector3d p_W_mm, double radius_mm,
                                                                  TimePoint deadline) override {
    return tracker_.aim(p_W_mm, radius_mm, deadline);
  }
  asio::awaitable<std::expected<drivers::SmrPoint, drivers::TrackerError>> measure(
      TimePoint deadline) override {
    last.reset();
    auto measured = co_await tracker_.measure(deadline);
    if (!measured) co_return measured;
    spoil(*measured);
    // As the driver of a real tracker does.
    if (auto why = drivers::implausible(*measured))
      co_return std::unexpected(drivers::TrackerError{drivers::TrackerFault::Refused, *std::move(why)});
    last = *measured;
    co_return measured;
  }
  void average_over(drivers::Duration time) override { tracker_.average_over(time); }
  asio::awaitable<std::expected<void, drivers::TrackerError>> turn_over(TimePoint deadline) override {
    return tracker_.turn_over(deadline);
  }
  asio::awaitable<std::expected<void, drivers::TrackerError>> check(TimePoint deadline) override {
    return tracker_.check(deadline);
  }
  void disconnect() noexcept override { tracker_.disconnect(); }

  std::optional<drivers::SmrPoint> last;
  Eigen::Vector3d offset_mm{0, 0, 0};  ///< of the last point from where it was seen

 private:
  void spoil(drivers::SmrPoint& point) {
    offset_mm = points_++ >= bad_.pushed_after ? bad_.pushed_by_mm : Eigen::Vector3d{0, 0, 0};
    if (random_.uniform() < bad_.loose_share) {
      for (double& coordinate : offset_mm) coordinate += 3 * random_.normal();
      point.std_mm.setConstant(3);
    }
    if (random_.uniform() < bad_.odd_share) spoil_what_is_told(point);
    point.p_WS_mm += offset_mm;
  }

  void spoil_what_is_told(drivers::SmrPoint& point) {
    const double which = random_.uniform();
    if (which < 0.25) point.std_mm.setConstant(-1);
    if (which >= 0.25 && which < 0.5) point.std_mm.setConstant(1e9);
    if (which >= 0.5 && which < 0.75) point.temperature_c = -273;
    if (which >= 0.75) point.pressure_mbar = 0;
  }

  drivers::Tracker& tracker_;
  BadData bad_;
  Random random_{0};
  int points_ = 0;
};

bool is_plausible(const drivers::SmrPoint& point) {
  return point.std_mm.minCoeff() >= 0 && point.std_mm.maxCoeff() < 1 && point.temperature_c > -50 &&
         point.pressure_mbar > 500;
}

/// The whole cell, and the promises that it has to keep at every step.
class Soak {
 public:
  explicit Soak(std::uint64_t seed) : random_{seed} {
    drivers::MockCellOptions truth = test::example_truth();
    truth.seed = seed;
    cell_.emplace(truth, clock_);
    robot_.emplace(*cell_);
    mock_tracker_.emplace(*cell_);
    tracker_.emplace(*mock_tracker_);
  }

  CampaignSoak run(double hours) {
    while (elapsed_hours() < hours && !testing::Test::HasFailure()) run_campaign();
    result_.hours = elapsed_hours();
    result_.hash = hash_.value();
    return result_;
  }

 private:
  struct Journal;
  struct Observer;

  double elapsed_hours() const {
    return std::chrono::duration<double, std::ratio<3600>>(clock_.now() - TimePoint{}).count();
  }
  double uniform(double min, double max) { return random_.uniform(min, max); }
  drivers::MockFaults draw_faults();
  BadData draw_bad_data(int identify_poses);
  void run_campaign();
  void interfere(daemon::Campaign& campaign, const bool& ended);
  void after(double seconds, std::function<void()> action);
  daemon::CellStep step(const daemon::CellEvent& event);
  /// @param total  poses that the campaign says there were
  using Outcome = std::expected<std::shared_ptr<const daemon::CampaignResult>, daemon::CampaignError>;
  void check_end(int total, const Journal& journal, const Outcome& outcome);
  void check_result(const daemon::CampaignResult& result);

  Random random_;
  asio::io_context io_;
  drivers::VirtualClock clock_;
  std::optional<drivers::MockCell> cell_;
  std::optional<drivers::MockRobot> robot_;
  std::optional<drivers::MockTracker> mock_tracker_;
  std::optional<WatchedTracker> tracker_;
  daemon::CellState state_ = daemon::Disconnected{};
  int actions_ = 0;  ///< of the operator, still to come
  BadData bad_;
  bool compute_failed_ = false;
  EventHash hash_;
  CampaignSoak result_;
};

/// Checks each point when it is stored, while the arm still stands where it was measured.
struct Soak::Journal final : daemon::CampaignJournal {
  /// The store fails at this of its calls, and from then on.
  Journal(Soak& s, int fails_at) : soak{s}, calls_left{fails_at} {}

  daemon::StoreResult<void> kept() {
    EXPECT_FALSE(failed) << "goes on after the store has failed";
    failed = calls_left-- == 0;
    if (failed) return std::unexpected(daemon::StoreError{"database or disk is full"});
    return {};
  }

  asio::awaitable<daemon::StoreResult<std::string>> begin(int) override {
    EXPECT_EQ(++begun, 1);
    const daemon::StoreResult<void> written_down = kept();
    if (!written_down) co_return std::unexpected(written_down.error());
    co_return std::string{};
  }

  asio::awaitable<daemon::StoreResult<void>> know(daemon::Identities) override { co_return kept(); }

  asio::awaitable<daemon::StoreResult<void>> add_planned(std::vector<daemon::PlannedPose> more,
                                                         int) override {
    for (const daemon::PlannedPose& pose : more)
      EXPECT_TRUE(planned.insert(pose.pose).second) << "pose " << pose.pose;
    co_return kept();
  }

  asio::awaitable<daemon::StoreResult<void>> add_identified(std::string) override { co_return kept(); }

  asio::awaitable<daemon::StoreResult<void>> add_resumption(daemon::Resumption) override {
    ADD_FAILURE() << "it was not interrupted";
    co_return kept();
  }

  asio::awaitable<daemon::StoreResult<daemon::StoredPoint>> add_point(daemon::StoredPoint point) override {
    const TimePoint written = soak.clock_.now() + 4ms;
    co_await soak.clock_.sleep_until(written);
    EXPECT_TRUE(soak.tracker_->last) << "a point was stored for a measurement that failed";
    const drivers::SmrPoint measured = soak.tracker_->last.value_or(drivers::SmrPoint{});
    EXPECT_EQ(measured.p_WS_mm, point.p_WS_mm);
    EXPECT_EQ(measured.std_mm, point.std_mm);
    EXPECT_TRUE(is_plausible(measured)) << "a point was stored that cannot be";
    EXPECT_EQ(soak.cell_->q(), point.q_actual) << "the arm moved on before its point was stored";
    EXPECT_EQ(point.q_actual, point.q_commanded);
    EXPECT_LT((*point.p_WS_mm - soak.tracker_->offset_mm - soak.cell_->p_WS_mm()).norm(), kSixSigma_mm)
        << "far from where the reflector really is";
    EXPECT_LT((point.q_commanded - point.q_target).cwiseAbs().maxCoeff(), kLargestCorrection_rad);
    EXPECT_TRUE(point.purpose == daemon::PointPurpose::Remeasure || point.q_commanded == point.q_target);
    EXPECT_EQ(++poses[point.pose], 1) << "pose " << point.pose;
    EXPECT_TRUE(planned.contains(point.pose)) << "pose " << point.pose << " was not planned";
    ++points;
    soak.hash_.add("point");
    for (int i = 0; i < 3; ++i) soak.hash_.add((*point.p_WS_mm)[i]);
    const daemon::StoreResult<void> written_down = kept();
    if (!written_down) co_return std::unexpected(written_down.error());
    co_return point;
  }

  asio::awaitable<daemon::StoreResult<void>> add_skipped(daemon::SkippedPose pose) override {
    EXPECT_FALSE(pose.reason.empty());
    EXPECT_EQ(++poses[pose.pose], 1) << "pose " << pose.pose;
    ++skipped;
    soak.hash_.add("skipped " + std::to_string(pose.pose) + pose.reason);
    co_return kept();
  }

  asio::awaitable<daemon::StoreResult<void>> end(std::shared_ptr<const daemon::CampaignResult> result,
                                                 std::optional<daemon::CampaignError> error) override {
    EXPECT_EQ(begun, 1);
    EXPECT_EQ(++ended, 1);
    EXPECT_NE(result == nullptr, !error) << "either a result or an error";
    soak.hash_.add(error ? "error " + error->detail : std::string{"done"});
    if (failed || calls_left-- == 0)
      co_return std::unexpected(daemon::StoreError{"database or disk is full"});
    co_return daemon::StoreResult<void>{};
  }

  Soak& soak;
  int calls_left;
  bool failed = false;
  int begun = 0, ended = 0, points = 0, skipped = 0;
  std::set<int> planned;
  std::map<int, int> poses;  ///< how often each was stored or listed
};

struct Soak::Observer final : daemon::CampaignObserver {
  explicit Observer(Soak& s) : soak{s} {}
  void on_progress(const daemon::CampaignProgress& progress) override { check(progress); }
  void on_point(const daemon::StoredPoint&, double, const daemon::CampaignProgress& progress) override {
    check(progress);
  }
  void on_skipped(const daemon::StoredPoint&, const std::string&,
                  const daemon::CampaignProgress& progress) override {
    check(progress);
  }
  void on_trouble(const std::string& sentence) override {
    ++soak.result_.troubles;
    soak.hash_.add(sentence);
  }
  void on_paused(const std::string& sentence) override {
    soak.hash_.add(sentence);
    soak.step(daemon::CampaignPaused{});
    if (resume) resume();
  }
  void check(const daemon::CampaignProgress& progress) {
    EXPECT_GE(progress.done, done);
    EXPECT_LE(progress.done, progress.total);
    done = progress.done;
  }
  Soak& soak;
  int done = 0;
  std::function<void()> resume;  ///< an operator who has looked after the beam
};

drivers::MockFaults Soak::draw_faults() {
  drivers::MockFaults faults;
  // From a quiet shift to one in which every tenth call fails somehow.
  const double level = uniform(0, 0.02) * (random_.uniform() < 0.7 ? 1 : 0);
  for (double* rate :
       {&faults.robot_lost, &faults.robot_restart, &faults.robot_refused, &faults.robot_aborted,
        &faults.robot_silent, &faults.robot_not_ready, &faults.tracker_lost, &faults.tracker_restart,
        &faults.tracker_busy, &faults.tracker_silent, &faults.no_target, &faults.beam_broken}) {
    *rate = level * uniform(0, 2);
  }
  return faults;
}

/// Most campaigns are sound.
BadData Soak::draw_bad_data(int identify_poses) {
  BadData bad;
  const double kind = random_.uniform();
  if (kind < 0.12) {
    // In the middle of the identification, or before the validation.
    bad.pushed_after = static_cast<int>(identify_poses * (random_.uniform() < 0.5 ? uniform(0.35, 0.7) : 1));
    bad.pushed_by_mm = uniform(2, 6) * Eigen::Vector3d{0.6, 0, 0.8};
  } else if (kind < 0.18) {
    bad.loose_share = 1.0 / 6;
  } else if (kind < 0.24) {
    bad.odd_share = 0.1;
  }
  return bad;
}

void Soak::after(double seconds, std::function<void()> action) {
  ++actions_;
  const TimePoint when = clock_.now() + std::chrono::milliseconds{static_cast<long>(1000 * seconds)};
  asio::co_spawn(io_, clock_.sleep_until(when), [this, action](std::exception_ptr) {
    action();
    --actions_;
  });
}

daemon::CellStep Soak::step(const daemon::CellEvent& event) {
  const daemon::CellStep next = daemon::advance(state_, event, clock_.now());
  hash_.add(daemon::state_name(next.next));
  state_ = next.next;
  return next;
}

/// An operator that pauses, resumes and aborts. The state machine has to agree with the commands to the
/// campaign.
void Soak::interfere(daemon::Campaign& campaign, const bool& ended) {
  if (random_.uniform() < 0.3) {
    const double pause_s = uniform(0, 400);
    after(pause_s, [this, &campaign, &ended] {
      if (ended) return;
      const daemon::CellStep paused = step(daemon::CampaignPauseRequested{});
      if (!paused.refused) campaign.pause();
    });
    after(pause_s + uniform(1, 900), [this, &campaign, &ended] {
      if (ended) return;
      const daemon::CellStep resumed = step(daemon::CampaignResumeRequested{});
      if (!resumed.refused) campaign.resume();
    });
  }
  if (random_.uniform() < 0.15) {
    after(uniform(0, 600), [this, &campaign, &ended] {
      if (ended) return;
      const daemon::CellStep aborted = step(daemon::CampaignAbortRequested{});
      if (!aborted.refused) campaign.abort("the operator has had enough");
    });
  }
}

void Soak::run_campaign() {
  config::CellConfig config = test::example_cell();
  config.campaign.identify_poses = 14 + static_cast<int>(uniform(0, 6));
  config.campaign.validate_poses = 6 + static_cast<int>(uniform(0, 6));
  config.campaign.seed = random_.next();
  config.campaign.remeasure = random_.uniform() < 0.8;
  cell_->use_faults(draw_faults());
  bad_ = draw_bad_data(config.campaign.identify_poses);
  tracker_->spoil(bad_, random_.next());

  constexpr int kNever = -1;
  Journal journal{*this, random_.uniform() < 0.06 ? static_cast<int>(uniform(0, 40)) : kNever};
  Observer observer{*this};
  int jobs_left = random_.uniform() < 0.06 ? static_cast<int>(uniform(0, 6)) : kNever;
  compute_failed_ = false;
  const auto compute = [&jobs_left, this](std::function<void()> job) {
    compute_failed_ = jobs_left-- == 0;
    if (compute_failed_) throw std::runtime_error{kNoCompute};
    return test::compute_here(std::move(job));
  };
  daemon::Campaign campaign{config, {*robot_, *tracker_, clock_}, journal, observer, compute};
  const daemon::CellStep started = step(daemon::CampaignStartRequested{std::to_string(result_.campaigns)});
  ASSERT_FALSE(started.refused) << started.refused->sentence();

  bool ended = false;
  std::optional<std::expected<std::shared_ptr<const daemon::CampaignResult>, daemon::CampaignError>> outcome;
  asio::co_spawn(io_, campaign.run(), [&](std::exception_ptr failed, auto result) {
    ASSERT_FALSE(failed);
    ended = true;
    outcome.emplace(std::move(result));
    step(daemon::CampaignEnded{});
  });
  observer.resume = [&] {
    after(uniform(1, 900), [this, &campaign, &ended] {
      if (ended) return;
      const daemon::CellStep resumed = step(daemon::CampaignResumeRequested{});
      if (!resumed.refused) campaign.resume();
    });
  };
  interfere(campaign, ended);
  ASSERT_TRUE(clock_.run(io_, [&] { return ended && actions_ == 0; })) << "the campaign hangs";
  ASSERT_EQ(clock_.sleepers(), 0U) << "somebody still waits for the clock";
  ASSERT_EQ(io_.poll(), 0U) << "something is still to be run";
  ASSERT_EQ(daemon::state_name(state_), "ready");
  check_end(campaign.progress().total, journal, *outcome);
  // The cell goes home, or on to the next campaign.
  if (random_.uniform() < 0.5) step(daemon::DisconnectRequested{});
}

void Soak::check_end(int total, const Journal& journal, const Outcome& outcome) {
  ++result_.campaigns;
  result_.points += journal.points;
  result_.skipped += journal.skipped;
  result_.spoiled += bad_.is_biased() || bad_.loose_share > 0 || bad_.odd_share > 0;
  EXPECT_EQ(journal.ended, 1);
  if (!outcome) {
    const daemon::CampaignFault fault = outcome.error().fault;
    ++(fault == daemon::CampaignFault::Aborted ? result_.aborted : result_.failed);
    EXPECT_FALSE(outcome.error().detail.empty());
    EXPECT_EQ(fault == daemon::CampaignFault::Internal, outcome.error().detail == kNoCompute)
        << outcome.error().detail;
    EXPECT_NE(fault, daemon::CampaignFault::WrongArm) << outcome.error().detail;
    EXPECT_TRUE(fault != daemon::CampaignFault::Store ||
                outcome.error().detail == "database or disk is full");
    return;
  }
  ++result_.done;
  EXPECT_FALSE(journal.failed) << "a campaign is done whose points are not all stored";
  EXPECT_FALSE(compute_failed_);
  EXPECT_EQ(static_cast<int>(journal.poses.size()), total) << "a pose is neither measured nor listed";
  EXPECT_EQ(journal.poses.rbegin()->first, total);
  check_result(**outcome);
}

void Soak::check_result(const daemon::CampaignResult& result) {
  if (bad_.is_biased()) {
    result_.biased_activated += activates(result);
    EXPECT_FALSE(activates(result)) << "the tracker was pushed by " << bad_.pushed_by_mm.norm()
                                    << " mm after " << bad_.pushed_after << " points";
  }
  const auto& found = result.as<daemon::CalibrationResult>();
  if (!found.remeasured) return;
  hash_.add(found.remeasured->mean);
  const bool sound = !bad_.is_biased() && bad_.loose_share == 0;
  EXPECT_TRUE(!sound || found.remeasured->mean < found.calibration.validate->before.mean);
}

}  // namespace

CampaignSoak soak_campaigns(std::uint64_t seed, double hours) { return Soak{seed}.run(hours); }

}  // namespace truepose::soak
