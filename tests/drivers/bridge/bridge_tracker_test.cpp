// The driver for trackers behind a bridge, over connections in memory and in virtual time.
#include "drivers/bridge/bridge_tracker.hpp"

#include <gmock/gmock.h>

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>

#include "drivers/mock/virtual_clock.hpp"
#include "tests/drivers/bridge/fake_bridge.hpp"

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using namespace std::chrono_literals;
using bridge::ErrorCode, bridge::EventKind;
using testing::ElementsAre;
using testing::HasSubstr;

class BridgeTrackerTest : public testing::Test {
 protected:
  ~BridgeTrackerTest() override {
    tracker.disconnect();
    clock.run(io, [] { return false; });
  }

  template <class T>
  T run(asio::awaitable<T> call) {
    std::optional<T> result;
    asio::co_spawn(io, std::move(call),
                   asio::bind_cancellation_slot(cancel.slot(), [&](std::exception_ptr error, T value) {
                     thrown = error;
                     result = std::move(value);
                   }));
    EXPECT_TRUE(clock.run(io, [&] { return result.has_value(); })) << "it waits for ever";
    return *std::move(result);
  }

  TimePoint in(Duration time) const { return clock.now() + time; }
  auto connect() { return run(tracker.connect(in(180s))); }
  auto aim() { return run(tracker.aim({1000, 2000, -500}, 30, in(40s))); }
  auto measure(Duration within = 20s) { return run(tracker.measure(in(within))); }

  void expect_fault(const auto& outcome, TrackerFault fault, const std::string& says) {
    ASSERT_FALSE(outcome);
    EXPECT_EQ(outcome.error().fault, fault) << outcome.error().detail;
    EXPECT_THAT(outcome.error().detail, HasSubstr(says));
  }
  void expect_point() {
    const auto point = measure();
    ASSERT_TRUE(point) << point.error().detail;
    EXPECT_EQ(point->p_WS_mm, Eigen::Vector3d(1000, 2000, -500));
  }
  auto count(const std::string& name) { return std::ranges::count(fake.asked, name); }

  asio::io_context io;
  VirtualClock clock;
  MemoryNetwork network{io, clock};
  FakeBridge fake{io, network, clock};
  asio::cancellation_signal cancel;
  std::exception_ptr thrown;
  Air air{22, 985, 45};
  BridgeOptions options{.host = "bridge",
                        .port = FakeBridge::kPort,
                        .reflector = "SMR 0.5",
                        .air = [this]() -> std::expected<Air, std::string> { return air; },
                        .initialise_again = 30min,
                        .stream = network.streams()};
  BridgeTracker tracker{io.get_executor(), clock, options};
};

TEST_F(BridgeTrackerTest, GreetsAsksChoosesTheReflectorAndTellsTheAir) {
  const auto identity = connect();
  ASSERT_TRUE(identity) << identity.error().detail;
  EXPECT_EQ(identity->model, "T3");
  EXPECT_EQ(identity->serial, "4711");
  EXPECT_THAT(fake.asked, ElementsAre("hello", "status", "reflector", "air"));
  EXPECT_EQ(fake.status.reflector, "SMR 0.5");
  EXPECT_EQ(std::get<bridge::SetAir>(fake.requests.back()).air, air);
}

TEST_F(BridgeTrackerTest, AimsMeasuresAndTurnsOver) {
  ASSERT_TRUE(connect());
  const auto aimed = aim();
  ASSERT_TRUE(aimed) << aimed.error().detail;
  const auto& request = std::get<bridge::DoAim>(fake.requests.back());
  EXPECT_EQ(request.p_W_mm, Eigen::Vector3d(1000, 2000, -500));
  EXPECT_EQ(request.search_mm, 30);
  tracker.average_over(5s);
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_EQ(std::get<bridge::DoMeasure>(fake.requests.back()).time, 5s);
  EXPECT_EQ(point->std_mm, Eigen::Vector3d(0.005, 0.006, 0.007));
  EXPECT_EQ(point->pressure_mbar, 1000);
  EXPECT_FALSE(point->orientation);
  ASSERT_TRUE(run(tracker.turn_over(in(40s))));
  EXPECT_EQ(fake.status.face, 2);
  ASSERT_TRUE(run(tracker.turn_over(in(40s))));
  EXPECT_EQ(fake.status.face, 1);
}

TEST_F(BridgeTrackerTest, InitialisesATrackerThatIsNotAndAgainOnceItIsWarm) {
  fake.status.initialised = false;
  ASSERT_TRUE(connect());
  EXPECT_EQ(count("initialise"), 1);
  ASSERT_TRUE(connect());
  EXPECT_EQ(count("initialise"), 1);
  run(tracker.check(in(5s)));
  const TimePoint warm = clock.now() + 30min;
  run([](Clock& watch, TimePoint then) -> asio::awaitable<int> {
    co_await watch.sleep_until(then);
    co_return 0;
  }(clock, warm));
  ASSERT_TRUE(connect());
  EXPECT_EQ(count("initialise"), 2) << "half an hour after it was found switched on";
  ASSERT_TRUE(connect());
  EXPECT_EQ(count("initialise"), 2);
  fake.event(EventKind::WarmedUp);
  expect_fault(aim(), TrackerFault::NotReady, "warmed up");
  ASSERT_TRUE(connect());
  EXPECT_EQ(count("initialise"), 3) << "where it says so itself";
  EXPECT_TRUE(aim());
}

TEST_F(BridgeTrackerTest, SaysWhyTheTrackerIsNotReady) {
  fake.status.state = bridge::State::WarmingUp;
  fake.status.why = "the laser warms up for another 300 s";
  expect_fault(connect(), TrackerFault::NotReady, "another 300 s");
}

TEST_F(BridgeTrackerTest, NamesTheReflectorsThatTheBridgeKnows) {
  fake.status.reflectors = {"RRR"};
  expect_fault(connect(), TrackerFault::Refused, "\"SMR 0.5\", only: RRR");
  expect_fault(run(tracker.inspect(in(3s))), TrackerFault::Refused, "only: RRR");
}

TEST_F(BridgeTrackerTest, IsInspectedByQuestionsAlone) {
  ASSERT_TRUE(run(tracker.inspect(in(3s))));
  EXPECT_THAT(fake.asked, ElementsAre("hello", "status"));
}

TEST_F(BridgeTrackerTest, RefusesABridgeOfAnotherVersion) {
  fake.greeting.protocol = 2;
  expect_fault(connect(), TrackerFault::Protocol, "version 2");
}

TEST_F(BridgeTrackerTest, MakesAFaultOfEveryRefusal) {
  ASSERT_TRUE(connect());
  const std::vector<std::pair<ErrorCode, TrackerFault>> faults{
      {ErrorCode::Busy, TrackerFault::Busy},           {ErrorCode::NotReady, TrackerFault::NotReady},
      {ErrorCode::WarmingUp, TrackerFault::NotReady},  {ErrorCode::NotInitialised, TrackerFault::NotReady},
      {ErrorCode::NoTarget, TrackerFault::NoTarget},   {ErrorCode::BeamBroken, TrackerFault::BeamBroken},
      {ErrorCode::OutOfRange, TrackerFault::Refused},  {ErrorCode::NotOffered, TrackerFault::Refused},
      {ErrorCode::DeviceLost, TrackerFault::NotReady}, {ErrorCode::Failed, TrackerFault::Refused}};
  for (const auto& [code, fault] : faults) {
    fake.script("measure", [&](std::int64_t id, const auto&) { fake.refuse(id, code, "SDK error 7"); });
    expect_fault(measure(), fault, "SDK error 7");
  }
  fake.unscript("measure");
  expect_point();
  EXPECT_EQ(fake.connections, 1) << "none of them costs the connection";
}

TEST_F(BridgeTrackerTest, TakesTheOrientationOfA6DTarget) {
  ASSERT_TRUE(connect());
  fake.result.orientation = {.w = 0.6, .x = 0, .y = 0, .z = 0.8, .std_deg = 0.02};
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  ASSERT_TRUE(point->orientation);
  EXPECT_DOUBLE_EQ(point->orientation->sigma_rad, 0.02 * kRadPerDeg);
  EXPECT_NEAR(point->orientation->R_WT(0, 0), 0.36 - 0.64, 1e-12);
  EXPECT_NEAR(point->orientation->R_WT(1, 0), 2 * 0.6 * 0.8, 1e-12);
  fake.result.orientation->std_deg = 0;
  expect_fault(measure(), TrackerFault::Refused, "a standard deviation of 0 deg");
  fake.result.orientation->std_deg = 6;
  expect_fault(measure(), TrackerFault::Refused, "6 deg, plausible are more than 0 and at most 5 deg");
}

TEST_F(BridgeTrackerTest, NeverTakesAPointThatIsOldShortOrImpossible) {
  ASSERT_TRUE(connect());
  const bridge::Measured good = fake.result;
  fake.result.age = 1500ms;
  expect_fault(measure(), TrackerFault::Refused, "1500 ms before");
  fake.result = good;
  fake.result.averaged = 500ms;
  expect_fault(measure(), TrackerFault::Refused, "averaged over 500 ms");
  fake.result = good;
  fake.result.std_mm->setZero();
  expect_fault(measure(), TrackerFault::Refused, "exactly 0 mm");
  fake.result = good;
  fake.result.air.pressure_mbar = 101.3;  // kPa
  expect_fault(measure(), TrackerFault::Refused, "101.3 mbar");
  fake.result = good;
  fake.status.locked = false;
  expect_fault(measure(), TrackerFault::NoTarget, "no reflector is locked");
}

TEST_F(BridgeTrackerTest, EndsAMeasurementWhoseBeamIsBrokenAndStopsItBeforeTheNext) {
  ASSERT_TRUE(connect());
  fake.script("measure", [&](std::int64_t, const auto&) {
    fake.later(500ms, [&] { fake.event(EventKind::BeamLost); });
  });
  const TimePoint begun = clock.now();
  expect_fault(measure(), TrackerFault::BeamBroken, "broken");
  EXPECT_EQ(clock.now() - begun, 500ms);
  fake.unscript("measure");
  expect_point();
  EXPECT_EQ(count("stop"), 1);
}

TEST_F(BridgeTrackerTest, PassesOverTheLateResultOfAMeasurementThatWasLeft) {
  ASSERT_TRUE(connect());
  bridge::Measured other = fake.result;
  other.p_W_mm = {1, 2, 3};
  fake.script("measure",
              [&](std::int64_t id, const auto&) { fake.later(25s, [&, id] { fake.answer(id, other); }); });
  expect_fault(measure(20s), TrackerFault::Timeout, "gave no measurement");
  fake.script("measure", [&](std::int64_t id, const auto&) {
    fake.later(10s, [&, id] { fake.answer(id, fake.result); });
  });
  expect_point();
  EXPECT_EQ(fake.connections, 1);
  EXPECT_EQ(count("stop"), 1);
}

TEST_F(BridgeTrackerTest, AsksForASignOfLifeWhileItWaits) {
  ASSERT_TRUE(connect());
  fake.script("aim", [&](std::int64_t id, const auto&) { fake.later(9s, [&, id] { fake.answer(id); }); });
  EXPECT_TRUE(aim());
  EXPECT_GE(count("ping"), 3);
}

TEST_F(BridgeTrackerTest, GivesUpABridgeThatHangsWithinSeconds) {
  ASSERT_TRUE(connect());
  fake.script("aim", [](std::int64_t, const auto&) {});
  fake.script("ping", [](std::int64_t, const auto&) {});
  const TimePoint begun = clock.now();
  expect_fault(aim(), TrackerFault::Timeout, "does not answer its heartbeat");
  EXPECT_LE(clock.now() - begun, 5s);
  fake.unscript("aim");
  fake.unscript("ping");
  expect_fault(aim(), TrackerFault::Disconnected, "not connected");
  ASSERT_TRUE(connect());
  EXPECT_TRUE(aim());
}

TEST_F(BridgeTrackerTest, ClosesTheConnectionOnLinesThatAreNotOfTheProtocol) {
  for (const std::string& line :
       {std::string{"220 welcome"}, std::string{R"({"id": 999999, "ok": true})"},
        std::string{R"({"id": null, "ok": false, "code": "bad-request", "text": "eh?"})"},
        std::string(70'000, 'x')}) {
    ASSERT_TRUE(connect());
    fake.script("measure", [&](std::int64_t, const auto&) { fake.send(line); });
    expect_fault(measure(), TrackerFault::Protocol, "");
    expect_fault(measure(), TrackerFault::Disconnected, "");
    fake.unscript("measure");
  }
  ASSERT_TRUE(connect());
  fake.script("measure", [&](std::int64_t id, const auto&) { fake.answer(id); });
  expect_fault(measure(), TrackerFault::Protocol, "missing key 'x'");
}

TEST_F(BridgeTrackerTest, PutsRightWhatAnotherProgramChanged) {
  ASSERT_TRUE(connect());
  fake.status.reflector = "SMR 1.5";
  expect_point();
  EXPECT_EQ(fake.status.reflector, "SMR 0.5");
  const auto writes = count("air");
  fake.event(EventKind::SettingsChanged);
  expect_point();
  EXPECT_EQ(count("air"), writes + 1);
}

TEST_F(BridgeTrackerTest, RejectsAPointDuringWhichTheSettingsChanged) {
  ASSERT_TRUE(connect());
  fake.script("measure", [&](std::int64_t id, const auto&) {
    fake.event(EventKind::SettingsChanged);
    fake.answer(id, fake.result);
  });
  expect_fault(measure(), TrackerFault::NotReady, "another program");
  fake.unscript("measure");
  expect_point();
}

TEST_F(BridgeTrackerTest, SendsTheAirAgainOnceItHasChanged) {
  ASSERT_TRUE(connect());
  expect_point();
  EXPECT_EQ(count("air"), 1);
  air.temperature_c = 23;
  expect_point();
  EXPECT_EQ(count("air"), 2);
}

TEST_F(BridgeTrackerTest, CanBeCancelledWhileMeasuringAndMeasuresAgain) {
  ASSERT_TRUE(connect());
  fake.script("measure", [&](std::int64_t, const auto&) {
    fake.later(100ms, [&] { cancel.emit(asio::cancellation_type::terminal); });
  });
  run(tracker.measure(in(20s)));
  EXPECT_TRUE(thrown);
  fake.unscript("measure");
  expect_point();
}

TEST_F(BridgeTrackerTest, ReportsALostConnectionAndConnectsAgain) {
  ASSERT_TRUE(connect());
  fake.script("measure", [&](std::int64_t, const auto&) { fake.hang_up(); });
  expect_fault(measure(), TrackerFault::Disconnected, "ended");
  fake.unscript("measure");
  ASSERT_TRUE(connect());
  expect_point();
}

}  // namespace
}  // namespace truepose::drivers
