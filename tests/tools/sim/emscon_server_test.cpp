#include "tools/sim/emscon_server.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <random>

#include "drivers/leica/emscon_tracker.hpp"
#include "drivers/steady_clock.hpp"
#include "tests/drivers/leica/alarm_clock.hpp"

namespace truepose::sim {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using drivers::TrackerFault;

constexpr unsigned kSeed = 20261121;
constexpr double kSigma_mm = 0.01;

class StandingTarget final : public SimulatedTarget {
 public:
  TargetSight look() const override {
    if (on_look) on_look();
    return {p_WS_mm, false, std::chrono::steady_clock::now()};
  }
  std::optional<Eigen::Vector3d> p_WS_mm = Eigen::Vector3d{2500, 1200, -300};
  std::function<void()> on_look;
};

/// The real driver against the simulated tracker over loopback, a thousand times faster than life.
class SimulatedTracker : public testing::Test {
 protected:
  SimulatedTracker() { RecordProperty("seed", kSeed); }

  Eigen::Vector3d noisy(const Eigen::Vector3d& p_mm) {
    std::normal_distribution<double> error{0, kSigma_mm};
    return p_mm + Eigen::Vector3d{error(random_), error(random_), error(random_)};
  }

  drivers::EmsconOptions options(std::string reflector = "CCR-1.5in") const {
    return {.host = "127.0.0.1", .port = server.port(), .reflector = std::move(reflector), .measure = 2000ms};
  }

  static drivers::TimePoint soon() { return std::chrono::steady_clock::now() + 60s; }

  /// Runs one call of the driver to its end, the server beside it.
  template <class T>
  T run(asio::awaitable<T> call) {
    std::optional<T> result;
    std::exception_ptr thrown;
    asio::co_spawn(io, std::move(call), [&](std::exception_ptr error, T value) {
      thrown = error;
      result = std::move(value);
    });
    while (!result) io.run_one();
    if (thrown) std::rethrow_exception(thrown);
    return *std::move(result);
  }

  auto connect() { return run(tracker.connect(soon())); }
  auto aim(double radius_mm = 50) { return run(tracker.aim(aim_mm, radius_mm, soon())); }
  auto measure() { return run(tracker.measure(soon())); }

  std::mt19937 random_{kSeed};
  asio::io_context io;
  StandingTarget target;
  EmsconServer server{io.get_executor(),
                      target,
                      [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm); },
                      {.speedup = 1000}};
  drivers::SteadyClock clock;
  drivers::EmsconTracker tracker{io.get_executor(), clock, options()};
  Eigen::Vector3d aim_mm = *target.p_WS_mm + Eigen::Vector3d{10, -5, 8};
};

TEST_F(SimulatedTracker, IsConnectedAimedAndMeasuredWithinItsNoise) {
  const auto identity = connect();
  ASSERT_TRUE(identity) << identity.error().detail;
  EXPECT_EQ(identity->serial, "390793");
  EXPECT_EQ(identity->firmware, "3.8.900");
  const auto aimed = aim();
  ASSERT_TRUE(aimed) << aimed.error().detail;
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - *target.p_WS_mm).norm(), 5 * kSigma_mm);
  EXPECT_GT(point->std_mm.minCoeff(), 0);
  EXPECT_LT(point->std_mm.maxCoeff(), 5 * kSigma_mm);
  EXPECT_NEAR(point->temperature_c, 20, 1e-9);
  EXPECT_NEAR(point->pressure_mbar, 1013.25, 1e-9);
  EXPECT_NEAR(point->humidity_percent, 50, 1e-9);
}

TEST_F(SimulatedTracker, FollowsTheTargetWhileItIsSeen) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  target.p_WS_mm = Eigen::Vector3d{3000, -800, 700};
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - *target.p_WS_mm).norm(), 5 * kSigma_mm);
}

TEST_F(SimulatedTracker, ReportsALargeSpreadWhileTheArmMoves) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  target.on_look = [this] { *target.p_WS_mm += Eigen::Vector3d{1, 0, 0}; };
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_GT(point->std_mm.x(), 0.5);
  EXPECT_LT(point->std_mm.y(), 5 * kSigma_mm);
}

TEST_F(SimulatedTracker, LosesThePointToABrokenBeamAndMeasuresAgainAfterAiming) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  int looks = 0;
  target.on_look = [&] {
    if (++looks != 5) return;
    target.p_WS_mm.reset();  // in the middle of the measurement
  };
  const Eigen::Vector3d p_WS_mm = *target.p_WS_mm;
  const auto broken = measure();
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().fault, TrackerFault::BeamBroken) << broken.error().detail;

  target.p_WS_mm = p_WS_mm;
  const auto unlocked = measure();
  ASSERT_FALSE(unlocked) << "a lost reflector is not locked again by itself";
  EXPECT_EQ(unlocked.error().fault, TrackerFault::NoTarget);
  const auto aimed = aim();
  ASSERT_TRUE(aimed) << aimed.error().detail;
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - p_WS_mm).norm(), 5 * kSigma_mm);
}

TEST_F(SimulatedTracker, CannotLockWhileSomethingStandsInTheBeam) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  server.beam_break(10min);
  const auto point = measure();
  ASSERT_FALSE(point);
  const auto aimed = aim();
  ASSERT_FALSE(aimed);
  EXPECT_EQ(aimed.error().fault, TrackerFault::NoTarget) << aimed.error().detail;
}

TEST_F(SimulatedTracker, FindsNothingOutsideTheSearchRadius) {
  ASSERT_TRUE(connect());
  aim_mm = *target.p_WS_mm + Eigen::Vector3d{0, 60, 0};
  const auto missed = aim(50);
  ASSERT_FALSE(missed);
  EXPECT_EQ(missed.error().fault, TrackerFault::NoTarget) << missed.error().detail;
  const auto found = aim(70);
  EXPECT_TRUE(found) << found.error().detail;
}

TEST_F(SimulatedTracker, IsDisconnectedByARestartAndConnectsAgain) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  int looks = 0;
  target.on_look = [&] {
    if (++looks == 5) asio::post(io, [this] { server.restart(); });
  };
  const auto lost = measure();
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().fault, TrackerFault::Disconnected) << lost.error().detail;
  const auto still_lost = aim();
  ASSERT_FALSE(still_lost);
  EXPECT_EQ(still_lost.error().fault, TrackerFault::Disconnected);

  const auto identity = connect();
  ASSERT_TRUE(identity) << identity.error().detail;
  ASSERT_TRUE(aim());
  EXPECT_TRUE(measure());
}

TEST_F(SimulatedTracker, NamesTheReflectorsItKnowsWhenAskedForAnother) {
  drivers::EmsconTracker other{io.get_executor(), clock, options("TBR-0.5in")};
  const auto identity = run(other.connect(soon()));
  ASSERT_FALSE(identity);
  EXPECT_EQ(identity.error().detail,
            "the tracker knows no reflector \"TBR-0.5in\", only: CCR-1.5in, CCR-0.5in");
}

TEST_F(SimulatedTracker, RefusesASecondClientAndServesTheFirstOn) {
  ASSERT_TRUE(connect());
  drivers::EmsconTracker second{io.get_executor(), clock, options()};
  const auto refused = run(second.connect(soon()));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, TrackerFault::Busy) << refused.error().detail;
  EXPECT_TRUE(aim());

  tracker.disconnect();
  EXPECT_TRUE(run(second.connect(soon())));
}

TEST_F(SimulatedTracker, StopsAMeasurementThatRanIntoItsDeadline) {
  drivers::EmsconOptions slow = options();
  slow.measure = 24h;  // more than a minute of the simulation's time
  drivers::AlarmClock alarm{io};
  drivers::EmsconTracker patient{io.get_executor(), alarm, slow};
  ASSERT_TRUE(run(patient.connect({})));
  ASSERT_TRUE(run(patient.aim(aim_mm, 50, {})));
  int looks = 0;
  target.on_look = [&] {
    if (++looks == 50) alarm.ring();
  };
  const auto late = run(patient.measure({}));
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().fault, TrackerFault::Timeout) << late.error().detail;
  const auto aimed = run(patient.aim(aim_mm, 50, {}));
  EXPECT_TRUE(aimed) << aimed.error().detail;
}

}  // namespace
}  // namespace truepose::sim
