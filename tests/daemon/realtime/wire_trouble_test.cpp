// Campaigns with the real drivers, over connections in memory and in virtual time, to devices that go silent,
// are switched off, hang up or throw everybody out.
#include <gmock/gmock.h>

#include <boost/asio/detached.hpp>
#include <map>
#include <set>

#include "core/arm/forward.hpp"
#include "core/math/random.hpp"
#include "drivers/bridge/bridge_tracker.hpp"
#include "drivers/kuka/eki_robot.hpp"
#include "drivers/leica/emscon_tracker.hpp"
#include "tests/daemon/campaign_fixture.hpp"
#include "tests/daemon/wired_devices.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using drivers::MemoryNetwork;

enum class WireTrouble { Off, Reset, CutMidPacket, Silent, Storm };
constexpr std::array kTroubles{WireTrouble::Off, WireTrouble::Reset, WireTrouble::CutMidPacket,
                               WireTrouble::Silent, WireTrouble::Storm};
constexpr Duration kResumed = 5s;

/// Whose wire is disturbed.
enum class Disturbed { Controller, Tracker, Bridge };
constexpr std::array kDisturbed{Disturbed::Tracker, Disturbed::Bridge, Disturbed::Controller};

/// One campaign with the real drivers, that is disturbed again and again.
class DisturbedCampaign {
 public:
  DisturbedCampaign(WireTrouble trouble, Disturbed disturbed, std::uint64_t seed)
      : trouble_{trouble}, disturbed_{disturbed}, random_{seed} {
    config_.campaign.remeasure = false;
    config_.campaign.pause_after_lost = 0;
    observer_.at_waiting = [this](CellDevice which, const std::string& reason) { note(which, reason); };
  }

  void run() {
    asio::co_spawn(io_, campaign_.run(), [this](std::exception_ptr failed, Outcome ended) {
      ASSERT_FALSE(failed);
      outcome_.emplace(std::move(ended));
    });
    asio::co_spawn(io_, disturb(), asio::detached);
    ASSERT_TRUE(clock_.run(io_, [this] { return outcome_.has_value(); }));
    robot_.disconnect();
    tracker_->disconnect();
    clock_.run(io_, [] { return false; });
  }

  /// Every planned pose has one point or a reason, and every point is where the reflector was.
  void expect_sound() {
    ASSERT_TRUE(*outcome_) << outcome_->error().detail;
    std::multiset<int> poses;
    for (const StoredPoint& point : journal_.points) {
      poses.insert(point.pose);
      EXPECT_LT((*point.p_WS_mm - true_mm(point.q_actual)).norm(), 0.2) << "pose " << point.pose;
    }
    for (const SkippedPose& pose : journal_.skipped) poses.insert(pose.pose);
    int expected = 0;
    for (const int pose : poses) EXPECT_EQ(pose, ++expected) << "once each";
    EXPECT_GE(expected, 28);
    EXPECT_LE(slowest_, kResumed);
    EXPECT_GT(troubles, 0);
  }

  int troubles = 0;

 private:
  using Outcome = CampaignTest::Outcome;

  Eigen::Vector3d true_mm(const JointVector& q) const {
    return truth_.truth.X_WB * (forward_kinematics(truth_.truth.robot, q) * truth_.truth.p_FS_mm);
  }

  static MemoryNetwork::Ports ports_of(Disturbed disturbed) {
    switch (disturbed) {
      case Disturbed::Tracker:
        return {WiredTracker::kPort};
      case Disturbed::Bridge:
        return {WiredBridge::kPort};
      case Disturbed::Controller:
        break;
    }
    return {WiredController::kMotion, WiredController::kState};
  }

  asio::awaitable<void> disturb() {
    const MemoryNetwork::Ports ports = ports_of(disturbed_);
    while (!outcome_) {
      const TimePoint begins =
          clock_.now() + std::chrono::milliseconds{static_cast<int>(random_.uniform(5e3, 30e3))};
      co_await clock_.sleep_until(begins);
      if (outcome_) co_return;
      ++troubles;
      cause_gone_.reset();
      start(ports);
      const TimePoint ends =
          clock_.now() + (trouble_ == WireTrouble::Reset || trouble_ == WireTrouble::CutMidPacket ? 0s : 10s);
      co_await clock_.sleep_until(ends);
      end(ports);
      cause_gone_ = clock_.now();
    }
  }

  void start(const MemoryNetwork::Ports& ports) {
    switch (trouble_) {
      case WireTrouble::Off:
        return network_.power(ports, false);
      case WireTrouble::Reset:
        return network_.reset(ports);
      case WireTrouble::CutMidPacket:
        return network_.cut_after(ports, static_cast<std::size_t>(random_.uniform(1, 400)));
      case WireTrouble::Silent:
        return network_.silence(ports, true);
      case WireTrouble::Storm:
        return network_.storm(ports, true);
    }
  }
  void end(const MemoryNetwork::Ports& ports) {
    network_.power(ports, true);
    network_.silence(ports, false);
    network_.storm(ports, false);
  }

  /// How long it took from the end of the cause, or from when it was noticed, until the device was back.
  void note(CellDevice which, const std::string& reason) {
    if ((which == CellDevice::Controller) != (disturbed_ == Disturbed::Controller)) return;
    if (!reason.empty()) {
      if (!noticed_) noticed_ = clock_.now();
      return;
    }
    if (noticed_ && cause_gone_)
      slowest_ = std::max(slowest_, clock_.now() - std::max(*noticed_, *cause_gone_));
    noticed_.reset();
  }

  std::unique_ptr<drivers::TimedTracker> tracker() {
    if (disturbed_ == Disturbed::Bridge)
      return std::make_unique<drivers::BridgeTracker>(
          io_.get_executor(), clock_,
          drivers::BridgeOptions{.host = "bridge", .port = WiredBridge::kPort, .stream = network_.streams()});
    return std::make_unique<drivers::EmsconTracker>(
        io_.get_executor(), clock_,
        drivers::EmsconOptions{.host = "tracker", .port = WiredTracker::kPort, .stream = network_.streams()});
  }

  WireTrouble trouble_;
  Disturbed disturbed_;
  Random random_;
  config::CellConfig config_ = test::example_cell();
  drivers::MockCellOptions truth_ = test::example_truth();
  asio::io_context io_;
  drivers::VirtualClock clock_;
  drivers::MockCell cell_{truth_, clock_};
  MemoryNetwork network_{io_, clock_};
  WiredController controller_{network_, cell_};
  WiredTracker wired_tracker_{io_, network_, cell_};
  WiredBridge wired_bridge_{io_, network_, cell_};
  drivers::KukaEkiRobot robot_{io_.get_executor(),
                               clock_,
                               {.host = "controller",
                                .motion_port = WiredController::kMotion,
                                .state_port = WiredController::kState,
                                .stream = network_.streams()}};
  std::unique_ptr<drivers::TimedTracker> tracker_ = tracker();
  test::MemoryJournal journal_;
  test::RecordingObserver observer_;
  Campaign campaign_{config_, CampaignDevices{robot_, *tracker_, clock_}, journal_, observer_,
                     &test::compute_here};
  std::optional<Outcome> outcome_;
  std::optional<TimePoint> noticed_, cause_gone_;
  Duration slowest_{0};
};

struct DisturbedWire : testing::TestWithParam<WireTrouble> {};

TEST_P(DisturbedWire, ResumesWithinSecondsAndMeasuresEachPoseOnce) {
  for (const Disturbed device : kDisturbed) {
    int troubles = 0;
    for (std::uint64_t seed = 1; troubles < trials(500); ++seed) {
      SCOPED_TRACE("device " + std::to_string(static_cast<int>(device)) + ", seed " + std::to_string(seed));
      DisturbedCampaign campaign{GetParam(), device, seed};
      campaign.run();
      if (HasFatalFailure()) return;
      campaign.expect_sound();
      if (HasFailure()) return;
      troubles += campaign.troubles;
    }
  }
}

void PrintTo(WireTrouble trouble, std::ostream* out) {
  *out << std::array{"off", "reset", "cut in the midst of a packet", "silent",
                     "a storm of reconnections"}[static_cast<std::size_t>(trouble)];
}

INSTANTIATE_TEST_SUITE_P(OfEveryKind, DisturbedWire, testing::ValuesIn(kTroubles));

}  // namespace
}  // namespace truepose::daemon
