// Processes that run a campaign and are killed at random instants. Their devices are the mock's and their
// time is virtual, so that a campaign passes in a moment; the store's file and the kill are real.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <random>

#include "daemon/campaign/campaign_options.hpp"
#include "daemon/campaign/store_journal.hpp"
#include "tests/daemon/cell_fixture.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;

/// Writes each pose that clients are notified of to a pipe.
struct TellingObserver final : CampaignObserver {
  explicit TellingObserver(int p) : pipe{p} {}
  void tell(int pose) const {
    if (::write(pipe, &pose, sizeof pose) != sizeof pose) ::_exit(3);
  }
  void on_progress(const CampaignProgress&) override {}
  void on_point(const StoredPoint& point, double, const CampaignProgress&) override { tell(point.pose); }
  void on_skipped(const StoredPoint& wanted, const std::string&, const CampaignProgress&) override {
    tell(wanted.pose);
  }
  void on_trouble(const std::string&) override {}
  void on_paused(const std::string&) override {}
  int pipe;
};

config::CellConfig small_cell() {
  config::CellConfig config = test::example_cell();
  config.campaign.identify_poses = 12;
  config.campaign.validate_poses = 5;
  config.campaign.reference_every = 6;
  return config;
}

/// What the process does: begins the campaign, or continues with it. @return its exit code
int live(const std::filesystem::path& file, const std::string& id, int pipe) {
  auto store = Store::open(file);
  if (!store || !store->plans().interrupt_running("2026-02-03T08:00:00Z")) return 2;
  const auto known = store->campaign(id);
  if (!known) return 2;
  if (*known && (*known)->state == "done") return 0;  // killed after its last record
  std::shared_ptr<const CampaignPast> past;
  if (*known) {
    auto read = read_past(*store, id);
    if (!read) return 2;
    past = std::make_shared<const CampaignPast>(*std::move(read));
  }
  const config::CellConfig config = small_cell();
  InPlaceWorker thread;
  TellingObserver observer{pipe};
  StoreJournal::Options options{.campaign_id = id,
                                .order = order_text(CalibrationOrder{}, config, true),
                                .model_id = "model of " + id,
                                .config = config};
  if (past) options.interrupted = past->record;
  if (past && !past->points.empty()) options.measured_before = past->points.back().time;
  asio::io_context io;
  drivers::VirtualClock clock;
  StoreJournal journal{options, *store, thread, [] { return std::chrono::system_clock::time_point{}; },
                       clock};
  drivers::MockCellOptions truth = test::example_truth();
  truth.faults.tracker_busy = 0.05;
  truth.seed = past ? past->points.size() : 0;
  drivers::MockCell cell{truth, clock};
  drivers::MockRobot robot{cell};
  drivers::MockTracker tracker{cell};
  Campaign campaign{
      config, {robot, tracker, clock}, journal, observer, &test::compute_here, CalibrationOrder{}, past};
  bool ended = false, done = false;
  asio::co_spawn(io, campaign.run(), [&](std::exception_ptr failed, auto outcome) {
    ended = true;
    done = !failed && outcome;
  });
  clock.run(io, [&] { return ended; });
  return done ? 0 : 1;
}

/// A process that measures, and the poses that it has written.
class Measuring {
 public:
  Measuring(const std::filesystem::path& file, const std::string& id) {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) throw std::runtime_error{"no pipe"};
    pid_ = ::fork();
    if (pid_ == 0) {
      ::close(ends[0]);
      ::_exit(live(file, id, ends[1]));
    }
    ::close(ends[1]);
    pipe_ = ends[0];
  }
  ~Measuring() { ::close(pipe_); }
  Measuring(const Measuring&) = delete;
  Measuring& operator=(const Measuring&) = delete;

  void kill_after(std::chrono::microseconds time) const {
    ::usleep(static_cast<useconds_t>(time.count()));
    ::kill(pid_, SIGKILL);
  }
  /// @return its exit code, or nothing where it was killed
  std::optional<int> wait() const {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    return WIFEXITED(status) ? std::optional{WEXITSTATUS(status)} : std::nullopt;
  }
  std::vector<int> reported() const {
    std::vector<int> poses;
    for (int pose = 0; ::read(pipe_, &pose, sizeof pose) == sizeof pose;) poses.push_back(pose);
    return poses;
  }

 private:
  pid_t pid_ = 0;
  int pipe_ = -1;
};

TEST(ACampaignWhoseProcessIsKilledAgainAndAgain, LosesNothingThatWasReportedAndComesToItsEnd) {
  const TempFolder folder;
  const std::filesystem::path file = folder.path() / "cell.sqlite";
  const std::uint64_t seed = std::random_device{}();
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random{seed};
  int kills = 0, done = 0;
  for (int campaign = 1; kills < trials(800); ++campaign) {
    const std::string id = "c" + std::to_string(campaign);
    std::set<int> reported;
    std::optional<int> exit_code;
    double longest_us = 30'000;  // that it is let live: longer each time, so that it comes to its end
    while (!exit_code) {
      const Measuring process{file, id};
      process.kill_after(std::chrono::microseconds{
          static_cast<std::int64_t>(std::uniform_real_distribution{0.0, longest_us}(random))});
      exit_code = process.wait();
      for (const int pose : process.reported())
        EXPECT_TRUE(reported.insert(pose).second) << "pose " << pose << " twice";
      longest_us *= 1.25;
      kills += !exit_code;

      Store store = Store::open(file).value();
      std::set<int> kept;
      const std::vector<StoredPoint> points = store.points(id).value();
      for (const StoredPoint& point : points) {
        if (!is_pose(point.purpose)) continue;
        EXPECT_TRUE(kept.insert(point.pose).second) << point.pose;
      }
      const std::vector<SkippedPose> given_up = store.skipped(id).value();
      for (const SkippedPose& skipped : given_up)
        EXPECT_TRUE(kept.insert(skipped.pose).second) << skipped.pose;
      EXPECT_THAT(kept, testing::IsSupersetOf(reported));
      EXPECT_LE(kept.size(), reported.size() + 1);
      // A pose that was stored in the moment of the kill is known, and not reported again.
      reported = kept;
    }
    EXPECT_EQ(*exit_code, 0) << id;
    Store store = Store::open(file).value();
    const CampaignRecord ended = store.campaign(id).value().value();
    EXPECT_EQ(ended.state, "done") << ended.reason;
    EXPECT_EQ(store.active_model().value()->campaign_id, id);
    ++done;
    if (testing::Test::HasFailure()) break;
  }
  std::printf("%d kills, %d campaigns done\n", kills, done);
}

}  // namespace
}  // namespace truepose::daemon
