#include "tests/soak/campaign_soak.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "core/random.hpp"
#include "daemon/campaign/campaign.hpp"
#include "daemon/cell/cell_state.hpp"
#include "drivers/mock/mock_robot.hpp"
#include "drivers/mock/mock_tracker.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "tests/daemon/example_cell.hpp"
#include "tests/soak/event_hash.hpp"

namespace truepose::soak {

namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using daemon::TimePoint;

constexpr double kLargestCorrection_rad = 0.35;
constexpr double kSixSigma_mm = 6 * 0.01 * 1.8;

/// Remembers the last measurement that did not fail.
class WatchedTracker final : public drivers::Tracker {
 public:
  explicit WatchedTracker(drivers::Tracker& tracker) : tracker_{tracker} {}

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
    if (measured) last = measured->p_WS_mm;
    co_return measured;
  }
  void disconnect() noexcept override { tracker_.disconnect(); }

  std::optional<Eigen::Vector3d> last;

 private:
  drivers::Tracker& tracker_;
};

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
  void run_campaign();
  void interfere(daemon::Campaign& campaign, const bool& ended);
  void after(double seconds, std::function<void()> action);
  daemon::CellStep step(const daemon::CellEvent& event);
  /// @param total  poses that the campaign says there were
  void check_end(
      int total, const Journal& journal,
      const std::expected<std::shared_ptr<const daemon::CampaignResult>, daemon::CampaignError>& outcome);

  Random random_;
  asio::io_context io_;
  drivers::VirtualClock clock_;
  std::optional<drivers::MockCell> cell_;
  std::optional<drivers::MockRobot> robot_;
  std::optional<drivers::MockTracker> mock_tracker_;
  std::optional<WatchedTracker> tracker_;
  daemon::CellState state_ = daemon::Disconnected{};
  int actions_ = 0;  ///< of the operator, still to come
  EventHash hash_;
  CampaignSoak result_;
};

/// Checks each point when it is stored, while the arm still stands where it was measured.
struct Soak::Journal final : daemon::CampaignJournal {
  explicit Journal(Soak& s) : soak{s} {}

  asio::awaitable<daemon::StoreResult<void>> begin(daemon::Identities) override {
    EXPECT_EQ(++begun, 1);
    co_return daemon::StoreResult<void>{};
  }

  asio::awaitable<daemon::StoreResult<void>> add_point(daemon::StoredPoint point) override {
    const TimePoint written = soak.clock_.now() + 4ms;
    co_await soak.clock_.sleep_until(written);
    EXPECT_TRUE(soak.tracker_->last) << "a point was stored for a measurement that failed";
    EXPECT_EQ(soak.tracker_->last.value_or(Eigen::Vector3d::Zero()), point.p_WS_mm);
    EXPECT_EQ(soak.cell_->q(), point.q_actual) << "the arm moved on before its point was stored";
    EXPECT_EQ(point.q_actual, point.q_commanded);
    EXPECT_LT((point.p_WS_mm - soak.cell_->p_WS_mm()).norm(), kSixSigma_mm)
        << "far from where the reflector really is";
    EXPECT_LT((point.q_commanded - point.q_target).cwiseAbs().maxCoeff(), kLargestCorrection_rad);
    EXPECT_TRUE(point.purpose == daemon::PointPurpose::Remeasure || point.q_commanded == point.q_target);
    EXPECT_EQ(++poses[point.pose], 1) << "pose " << point.pose;
    ++points;
    soak.hash_.add("point");
    for (int i = 0; i < 3; ++i) soak.hash_.add(point.p_WS_mm[i]);
    co_return daemon::StoreResult<void>{};
  }

  asio::awaitable<daemon::StoreResult<void>> add_skipped(daemon::SkippedPose pose) override {
    EXPECT_FALSE(pose.reason.empty());
    EXPECT_EQ(++poses[pose.pose], 1) << "pose " << pose.pose;
    ++skipped;
    soak.hash_.add("skipped " + std::to_string(pose.pose) + pose.reason);
    co_return daemon::StoreResult<void>{};
  }

  asio::awaitable<daemon::StoreResult<void>> end(std::shared_ptr<const daemon::CampaignResult> result,
                                                 std::optional<daemon::CampaignError> error) override {
    EXPECT_EQ(begun, 1);
    EXPECT_EQ(++ended, 1);
    EXPECT_NE(result == nullptr, !error) << "either a result or an error";
    soak.hash_.add(error ? "error " + error->detail : std::string{"done"});
    co_return daemon::StoreResult<void>{};
  }

  Soak& soak;
  int begun = 0, ended = 0, points = 0, skipped = 0;
  std::map<int, int> poses;  ///< how often each was stored or listed
};

struct Soak::Observer final : daemon::CampaignObserver {
  explicit Observer(Soak& s) : soak{s} {}
  void on_progress(const daemon::CampaignProgress& progress) override { check(progress); }
  void on_point(const daemon::StoredPoint&, double, const daemon::CampaignProgress& progress) override {
    check(progress);
  }
  void on_skipped(const daemon::SkippedPose&, const daemon::CampaignProgress& progress) override {
    check(progress);
  }
  void on_trouble(const std::string& sentence) override {
    ++soak.result_.troubles;
    soak.hash_.add(sentence);
  }
  void check(const daemon::CampaignProgress& progress) {
    EXPECT_GE(progress.done, done);
    EXPECT_LE(progress.done, progress.total);
    done = progress.done;
  }
  Soak& soak;
  int done = 0;
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

/// An operator who pauses, goes on and aborts. The state machine has to agree with what the campaign is told.
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

  Journal journal{*this};
  Observer observer{*this};
  daemon::Campaign campaign{config, {*robot_, *tracker_, clock_}, journal, observer, &test::compute_here};
  const daemon::CellStep started = step(daemon::CampaignStartRequested{std::to_string(result_.campaigns)});
  ASSERT_FALSE(started.refused) << started.refused->sentence();
  ASSERT_EQ(started.commands, std::vector{daemon::CellCommand::StartCampaign});

  bool ended = false;
  std::optional<std::expected<std::shared_ptr<const daemon::CampaignResult>, daemon::CampaignError>> outcome;
  asio::co_spawn(io_, campaign.run(), [&](std::exception_ptr failed, auto result) {
    ASSERT_FALSE(failed);
    ended = true;
    outcome.emplace(std::move(result));
    step(daemon::CampaignEnded{});
  });
  interfere(campaign, ended);
  ASSERT_TRUE(clock_.run(io_, [&] { return ended && actions_ == 0; })) << "the campaign hangs";
  ASSERT_EQ(clock_.sleepers(), 0U) << "somebody still waits for the clock";
  ASSERT_EQ(io_.poll(), 0U) << "something is still to be run";
  ASSERT_EQ(daemon::state_name(state_), "ready");
  check_end(campaign.progress().total, journal, *outcome);
  // The cell goes home, or on to the next campaign.
  if (random_.uniform() < 0.5) step(daemon::DisconnectRequested{});
}

void Soak::check_end(
    int total, const Journal& journal,
    const std::expected<std::shared_ptr<const daemon::CampaignResult>, daemon::CampaignError>& outcome) {
  ++result_.campaigns;
  result_.points += journal.points;
  result_.skipped += journal.skipped;
  EXPECT_EQ(journal.ended, 1);
  if (!outcome) {
    const bool aborted = outcome.error().fault == daemon::CampaignFault::Aborted;
    ++(aborted ? result_.aborted : result_.failed);
    EXPECT_FALSE(outcome.error().detail.empty());
    EXPECT_NE(outcome.error().fault, daemon::CampaignFault::Internal) << outcome.error().detail;
    EXPECT_NE(outcome.error().fault, daemon::CampaignFault::WrongArm) << outcome.error().detail;
    return;
  }
  ++result_.done;
  EXPECT_EQ(static_cast<int>(journal.poses.size()), total) << "a pose is neither measured nor listed";
  EXPECT_EQ(journal.poses.rbegin()->first, total - 1);
  const daemon::CampaignResult& result = **outcome;
  if (!result.remeasured) return;
  hash_.add(result.remeasured->mean);
  EXPECT_LT(result.remeasured->mean, result.calibration.validate->before.mean);
}

}  // namespace

CampaignSoak soak_campaigns(std::uint64_t seed, double hours) { return Soak{seed}.run(hours); }

}  // namespace truepose::soak
