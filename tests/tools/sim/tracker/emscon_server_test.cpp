#include "tools/sim/tracker/emscon_server.hpp"

#include <cmath>
#include <tuple>
#include <vector>

#include "tests/drivers/leica/alarm_clock.hpp"
#include "tests/tools/sim/tracker/emscon_server_fixture.hpp"

namespace truepose::sim {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using drivers::TrackerFault;

TEST_F(EmsconServerTest, IsConnectedAimedAndMeasuredWithinItsNoise) {
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

TEST_F(EmsconServerTest, FollowsTheTargetWhileItIsSeen) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  target.p_WS_mm = Eigen::Vector3d{3000, -800, 700};
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - *target.p_WS_mm).norm(), 5 * kSigma_mm);
}

TEST_F(EmsconServerTest, ReportsALargeSpreadWhileTheArmMoves) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  target.on_look = [this] { *target.p_WS_mm += Eigen::Vector3d{1, 0, 0}; };
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_GT(point->std_mm.x(), 0.5);
  EXPECT_LT(point->std_mm.y(), 5 * kSigma_mm);
}

TEST_F(EmsconServerTest, LosesThePointToABrokenBeamAndMeasuresAgainAfterAiming) {
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

TEST_F(EmsconServerTest, CannotLockWhileSomethingStandsInTheBeam) {
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  server.beam_break(10min);
  const auto point = measure();
  ASSERT_FALSE(point);
  const auto aimed = aim();
  ASSERT_FALSE(aimed);
  EXPECT_EQ(aimed.error().fault, TrackerFault::NoTarget) << aimed.error().detail;
}

TEST_F(EmsconServerTest, FindsNothingOutsideTheSearchRadius) {
  ASSERT_TRUE(connect());
  aim_mm = *target.p_WS_mm + Eigen::Vector3d{0, 60, 0};
  const auto missed = aim(50);
  ASSERT_FALSE(missed);
  EXPECT_EQ(missed.error().fault, TrackerFault::NoTarget) << missed.error().detail;
  const auto found = aim(70);
  EXPECT_TRUE(found) << found.error().detail;
}

TEST_F(EmsconServerTest, IsDisconnectedByARestartAndConnectsAgain) {
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

TEST_F(EmsconServerTest, NamesTheReflectorsItKnowsWhenAskedForAnother) {
  drivers::EmsconTracker other{io.get_executor(), clock, options("TBR-0.5in")};
  const auto identity = run(other.connect(soon()));
  ASSERT_FALSE(identity);
  EXPECT_EQ(identity.error().detail,
            "the tracker knows no reflector \"TBR-0.5in\", only: CCR-1.5in, CCR-0.5in");
}

TEST_F(EmsconServerTest, RefusesASecondClientAndServesTheFirstOn) {
  ASSERT_TRUE(connect());
  drivers::EmsconTracker second{io.get_executor(), clock, options()};
  const auto refused = run(second.connect(soon()));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, TrackerFault::Busy) << refused.error().detail;
  EXPECT_TRUE(aim());

  tracker.disconnect();
  EXPECT_TRUE(run(second.connect(soon())));
}

TEST_F(EmsconServerTest, StopsAMeasurementThatRanIntoItsDeadline) {
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

TEST_F(EmsconServerTest, MeasuresWhereTheTrackerWasPushedAndWhatItSaysIsWrong) {
  ASSERT_TRUE(connect());
  server.disturb({.moved_mm = {5, 0, 0}, .bias_mm = {0, 2, 0}, .std_mm = 50, .temperature_c = 55});
  ASSERT_TRUE(aim());
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_LT((point->p_WS_mm - *target.p_WS_mm - Eigen::Vector3d(5, 2, 0)).norm(), 5 * kSigma_mm);
  EXPECT_NEAR(point->std_mm.x(), 50, 1e-9);
  EXPECT_NEAR(point->temperature_c, 55, 1e-9);
  server.disturb({.temperature_c = -273});
  const auto cold = measure();
  ASSERT_FALSE(cold);
  EXPECT_NE(cold.error().detail.find("-273 C"), std::string::npos) << cold.error().detail;
}

/// A tracker that measures nearly without noise through the air of a high and hot place.
class TrackerInThinAir : public EmsconServerTest {
 protected:
  static constexpr Air kThin{34, 790, 65};

  /// How much too long the distance to the reflector comes out.
  double excess(bool weather_station, std::function<std::expected<Air, std::string>()> air) {
    TrackerServerOptions setup{.speedup = 1000};
    setup.instrument = {.weather_station = weather_station, .air = kThin};
    EmsconServer there{machine, target, [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm, 1e-7); },
                       setup};
    drivers::EmsconOptions to = options();
    to.port = there.port();
    to.air = std::move(air);
    drivers::EmsconTracker of{io.get_executor(), clock, to};
    there.disturb({.temperature_c = kThin.temperature_c,
                   .pressure_mbar = kThin.pressure_mbar,
                   .humidity_percent = kThin.humidity_percent});
    EXPECT_TRUE(run(of.connect(soon())));
    EXPECT_TRUE(run(of.aim(aim_mm, 50, soon())));
    const auto point = run(of.measure(soon()));
    EXPECT_TRUE(point) << point.error().detail;
    return point->p_WS_mm.norm() / target.p_WS_mm->norm() - 1;
  }
};

TEST_F(TrackerInThinAir, IsRightToATenthOfAMicrometreAMetreOnceItHasTheAir) {
  EXPECT_NEAR(excess(false, [] { return kThin; }), 0, 1e-7);
  EXPECT_NEAR(excess(true, [] { return kThin; }), 0, 1e-7);
}

TEST_F(TrackerInThinAir, IsWrongByWhatItTakesForItsAir) {
  // By the formula for the shop floor (Stone, Zimmerman), whose phase index scales alike.
  const double thin = 7.86e-4 * 79 / (273 + 34) - 1.5e-11 * 65 * (34 * 34 + 160);
  const double usual = 7.86e-4 * 101.325 / (273 + 20) - 1.5e-11 * 50 * (20 * 20 + 160);
  EXPECT_NEAR(excess(false, [] { return Air{20, 1013.25, 50}; }), thin - usual, 2e-6);
  EXPECT_GT(std::abs(excess(false, {})), 50e-6) << "what was in it came from a place by the sea";
}

TEST_F(TrackerInThinAir, NeedsNoTellingWhereItHasAWeatherStation) { EXPECT_NEAR(excess(true, {}), 0, 1e-9); }

/// One with errors of its directions, which sees other reflectors in addition to the arm's.
class OddTracker : public EmsconServerTest {
 protected:
  OddTracker() {
    TrackerServerOptions setup{.speedup = 1000};
    setup.instrument.aiming = {.collimation = 40e-6, .tilt = 20e-6, .index = -30e-6};
    setup.instrument.nests_mm = {{2500, -700, -300}, {1500, 900, -800}};
    odd.emplace(
        machine, target, [this](const Eigen::Vector3d& p_mm) { return noisy(p_mm, 1e-7); }, setup);
    drivers::EmsconOptions to = options();
    to.port = odd->port();
    driver.emplace(io.get_executor(), clock, to);
    EXPECT_TRUE(run(driver->connect(soon())));
  }
  Eigen::Vector3d point() {
    const auto measured = run(driver->measure(soon()));
    EXPECT_TRUE(measured) << measured.error().detail;
    return measured->p_WS_mm;
  }
  std::optional<EmsconServer> odd;
  std::optional<drivers::EmsconTracker> driver;
};

TEST_F(OddTracker, ErrsTheOtherWayInItsOtherFace) {
  ASSERT_TRUE(run(driver->aim(aim_mm, 50, soon())));
  const Eigen::Vector3d face1_mm = point();
  const auto turned = run(driver->turn_over(soon()));
  ASSERT_TRUE(turned) << turned.error().detail;
  const Eigen::Vector3d face2_mm = point();
  EXPECT_GT((face1_mm - *target.p_WS_mm).norm(), 0.08);
  EXPECT_LT(((face1_mm + face2_mm) / 2 - *target.p_WS_mm).norm(), 1e-4);
  ASSERT_TRUE(run(driver->aim(aim_mm, 50, soon())));
  EXPECT_LT((point() - face1_mm).norm(), 1e-5) << "after the next aim it is in face 1 again";
}

TEST_F(OddTracker, LocksToTheReflectorThatItIsAimedAt) {
  ASSERT_TRUE(run(driver->aim({2510, -690, -310}, 50, soon())));
  EXPECT_LT((point() - Eigen::Vector3d(2500, -700, -300)).norm(), 0.2);
  target.p_WS_mm.reset();
  EXPECT_LT((point() - Eigen::Vector3d(2500, -700, -300)).norm(), 0.2) << "it needs no arm for that";
  const auto arms = run(driver->aim(aim_mm, 50, soon()));
  ASSERT_FALSE(arms);
  EXPECT_EQ(arms.error().fault, TrackerFault::NoTarget);
}

TEST_F(EmsconServerTest, IsBusyForAnotherAndThenServesOn) {
  ASSERT_TRUE(connect());
  server.disturb({.busy = true});
  const auto refused = aim();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, TrackerFault::Busy) << refused.error().detail;
  server.disturb({});
  EXPECT_TRUE(aim());
}

TEST_F(EmsconServerTest, IsSilentAndItsClientWaitsNoLongerThanItWasGiven) {
  drivers::AlarmClock alarm{io};
  drivers::EmsconTracker patient{io.get_executor(), alarm, options()};
  ASSERT_TRUE(run(patient.connect({})));
  ASSERT_TRUE(run(patient.aim(aim_mm, 50, {})));
  server.disturb({.silent = true});
  int looks = 0;
  target.on_look = [&] {
    if (++looks % 50 == 0) alarm.ring();
  };
  const auto unanswered = run(patient.measure({}));
  ASSERT_FALSE(unanswered);
  EXPECT_EQ(unanswered.error().fault, TrackerFault::Timeout) << unanswered.error().detail;
}

TEST_F(EmsconServerTest, MeasuresThroughAStormOfReports) {
  server.disturb({.storms = true});
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  EXPECT_TRUE(measure());
}

}  // namespace
}  // namespace truepose::sim
