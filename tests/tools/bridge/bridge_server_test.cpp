// The simulated tracker behind a bridge: the driver before it, and the check of what a bridge promises.
#include "tools/sim/tracker/bridge_server.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "core/math/angles.hpp"
#include "drivers/bridge/bridge_tracker.hpp"
#include "tests/tools/sim/tracker/tracker_over_loopback.hpp"
#include "tools/truepose/bridge/conformance.hpp"

namespace truepose::sim {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using drivers::TrackerFault;
using tools::BridgeVerdict, tools::Conformance;

class SimulatedBridge : public TrackerOverLoopback {
 protected:
  SimulatedBridge() : TrackerOverLoopback{20261124} {}

  auto aim(double radius_mm = 50) { return run(tracker.aim(aim_mm, radius_mm, soon())); }
  auto measure() { return run(tracker.measure(soon())); }
  void expect_point(double within_mm = 5 * kSigma_mm) {
    const auto point = measure();
    ASSERT_TRUE(point) << point.error().detail;
    EXPECT_LT((point->p_WS_mm - *target.p_WS_mm).norm(), within_mm);
    EXPECT_GT(point->std_mm.minCoeff(), 0);
  }
  /// What the check finds, with or without the place of the reflector.
  std::vector<BridgeVerdict> examined(bool at = true) {
    tools::BridgeCheckOptions options{.host = "127.0.0.1", .port = server.port(), .measure = 500ms};
    if (at) options.reflector_mm = aim_mm;
    auto verdicts = run(tools::check_bridge(io.get_executor(), clock, std::move(options)));
    EXPECT_TRUE(verdicts) << verdicts.error();
    return verdicts.value_or(std::vector<BridgeVerdict>{});
  }
  static std::vector<std::string> failed(const std::vector<BridgeVerdict>& verdicts) {
    std::vector<std::string> promises;
    for (const BridgeVerdict& one : verdicts) {
      if (one.outcome != Conformance::Failed) continue;
      promises.push_back(one.promise);
      EXPECT_FALSE(one.found.empty());
      EXPECT_FALSE(one.next.empty());
    }
    return promises;
  }

  BridgeServer server{
      machine, target, [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm); }, {.speedup = 20}};
  drivers::BridgeTracker tracker{
      io.get_executor(), clock, {.host = "127.0.0.1", .port = server.port(), .reflector = "CCR-1.5in"}};
};

TEST_F(SimulatedBridge, IsConnectedAimedMeasuredAndTurnedOver) {
  const auto identity = run(tracker.connect(soon()));
  ASSERT_TRUE(identity) << identity.error().detail;
  EXPECT_EQ(identity->serial, "390793");
  ASSERT_TRUE(aim());
  expect_point();
  const auto turned = run(tracker.turn_over(soon()));
  ASSERT_TRUE(turned) << turned.error().detail;
  expect_point();
  ASSERT_TRUE(aim());
  target.p_WS_mm = Eigen::Vector3d{3000, -800, 700};
  expect_point();
  const auto missed = aim();
  ASSERT_FALSE(missed);
  EXPECT_EQ(missed.error().fault, TrackerFault::NoTarget) << missed.error().detail;
}

TEST_F(SimulatedBridge, TurnsA6DTargetAsItStands) {
  target.R_WT = rotation_zyx(0.7, -0.3, 2.5);
  BridgeServer of_probe{machine,
                        target,
                        [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm); },
                        {.speedup = 20,
                         .instrument = {.nests_mm = {{1500, -900, -600}}},
                         .orientation_noise = [](const Eigen::Matrix3d& R_true) {
                           return MeasuredOrientation{R_true, 1e-4};
                         }}};
  drivers::BridgeTracker of_it{io.get_executor(), clock, {.host = "127.0.0.1", .port = of_probe.port()}};
  ASSERT_TRUE(run(of_it.connect(soon())));
  ASSERT_TRUE(run(of_it.aim(aim_mm, 50, soon())));
  const auto probe = run(of_it.measure(soon()));
  ASSERT_TRUE(probe) << probe.error().detail;
  ASSERT_TRUE(probe->orientation);
  EXPECT_LT(angle_between(probe->orientation->R_WT, target.R_WT), 1e-9);
  EXPECT_NEAR(probe->orientation->sigma_rad, 1e-4, 1e-15);
  ASSERT_TRUE(run(of_it.aim({1500, -900, -600}, 50, soon())));
  EXPECT_FALSE(run(of_it.measure(soon())).value().orientation) << "a nest holds a plain reflector";
}

TEST_F(SimulatedBridge, EndsAMeasurementWhereTheBeamIsBroken) {
  ASSERT_TRUE(run(tracker.connect(soon())));
  ASSERT_TRUE(aim());
  asio::co_spawn(io, clock.sleep_until(std::chrono::steady_clock::now() + 20ms),
                 [this](std::exception_ptr) { server.beam_break(30ms); });
  const auto broken = measure();
  ASSERT_FALSE(broken);
  EXPECT_EQ(broken.error().fault, TrackerFault::BeamBroken) << broken.error().detail;
  run([](drivers::Clock& watch) -> asio::awaitable<int> {
    const auto later = watch.now() + 50ms;
    co_await watch.sleep_until(later);
    co_return 0;
  }(clock));
  ASSERT_TRUE(aim());
  expect_point();
}

TEST_F(SimulatedBridge, FindsAnotherReflectorOnRequest) {
  ASSERT_TRUE(run(tracker.connect(soon())));
  server.disturb({.stray_mm = Eigen::Vector3d{0, 40, 0}});
  ASSERT_TRUE(aim());
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - *target.p_WS_mm - Eigen::Vector3d(0, 40, 0)).norm(), 5 * kSigma_mm);
  server.disturb({});
  ASSERT_TRUE(aim());
  expect_point();
}

TEST_F(SimulatedBridge, KeepsEveryPromise) {
  for (const BridgeVerdict& verdict : examined())
    EXPECT_EQ(verdict.outcome, Conformance::Ok) << verdict.promise << ": " << verdict.found;
}

TEST_F(SimulatedBridge, IsNotMovedWhereNoReflectorIsNamed) {
  const auto verdicts = examined(false);
  EXPECT_THAT(failed(verdicts), testing::IsEmpty());
  EXPECT_GT(std::ranges::count(verdicts, Conformance::Skipped, &BridgeVerdict::outcome), 5);
  EXPECT_EQ(server.measurements(), 0U);
}

}  // namespace
}  // namespace truepose::sim
