#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/system/system_error.hpp>
#include <exception>
#include <limits>

#include "proto/emscon/status.hpp"
#include "tests/drivers/leica/emscon_fixture.hpp"

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using namespace emscon;
using enum CommandCode;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST_F(EmsconTrackerTest, WritesEverySettingThatCoordinatesDependOn) {
  const auto identity = connect();
  ASSERT_TRUE(identity) << identity.error().detail;
  EXPECT_EQ(identity->model, "AT401");
  EXPECT_EQ(identity->serial, "42");
  EXPECT_EQ(identity->firmware, "3.8.900");
  EXPECT_EQ(fake.kept[GetUnits], Body{Units{.length = LengthUnit::Millimeter}});
  EXPECT_EQ(fake.kept[GetCoordinateSystemType], Body{CoordinateSystemChoice{CoordinateSystem::Rhr}});
  EXPECT_EQ(fake.kept[GetMeasurementMode], Body{MeasurementModeChoice{MeasurementMode::Stationary}});
  EXPECT_EQ(fake.kept[GetStationaryModeParams], (Body{StationaryModeParams{1500, true}}));
  EXPECT_EQ(fake.kept[GetTransformationParams], Body{Transformation{}});
  EXPECT_EQ(fake.kept[GetStationOrientationParams], Body{StationOrientation{}});
  EXPECT_EQ(fake.kept[GetReflector], Body{ReflectorChoice{7}});
  const SystemSettings wanted{.weather = WeatherMonitor::ReadAndCompute,
                              .keep_last_position = true,
                              .send_unsolicited_messages = true};
  EXPECT_EQ(fake.kept[GetSystemSettings], Body{wanted});
  EXPECT_THAT(fake.commands, Not(Contains(Initialize)));
}

TEST_F(EmsconTrackerTest, LetsItsTapHearAllThatGoesOverTheWire) {
  using recording::Kind;
  ASSERT_TRUE(connect());
  tracker.disconnect();
  PacketSplitter sent;
  for (const auto& [kind, bytes] : heard) {
    if (kind == Kind::Sent) sent.push({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  }
  std::vector<CommandCode> commands;
  while (const auto packet = *sent.next())
    commands.push_back(std::get<Command>(*decode_client_packet(*packet)).code);
  EXPECT_EQ(commands, fake.commands);
  EXPECT_EQ(heard.front().first, Kind::Connected);
  EXPECT_THAT(heard.front().second, HasSubstr("127.0.0.1:"));
  EXPECT_EQ(heard.back().first, Kind::Closed);
}

TEST_F(EmsconTrackerTest, InitializesATrackerThatIsNot) {
  std::get<SystemStatus>(fake.kept[GetSystemStatus]).processor = ProcessorStatus::CompensationSet;
  EXPECT_TRUE(connect());
  EXPECT_EQ(count(Initialize), 1);
}

TEST_F(EmsconTrackerTest, InitializesATrackerAgainOnceItHasWarmedUp) {
  ASSERT_TRUE(connect());
  fake.script(GetMeasurementStatusInfo, [this] {
    fake.event(SystemEvent::LaserWarmedUp);
    fake.unscript(GetMeasurementStatusInfo);
    fake.answer(GetMeasurementStatusInfo, 0, fake.kept[GetMeasurementStatusInfo]);
  });
  const auto cold = aim();
  expect_fault(cold, TrackerFault::NotReady);
  EXPECT_THAT(cold.error().detail, HasSubstr("warmed up"));
  EXPECT_EQ(count(Initialize), 0);
  ASSERT_TRUE(connect());
  EXPECT_EQ(count(Initialize), 1);
  EXPECT_TRUE(aim());
  ASSERT_TRUE(connect());
  EXPECT_EQ(count(Initialize), 1);
}

TEST_F(EmsconTrackerTest, GivesUpATrackerThatDoesNotInitializeInTime) {
  std::get<SystemStatus>(fake.kept[GetSystemStatus]).processor = ProcessorStatus::Booted;
  fake.script(Initialize, [&] { clock.ring(); });
  expect_fault(connect(), TrackerFault::Timeout);
}

TEST_F(EmsconTrackerTest, RefusesATrackerWhoseLaserHeatsUp) {
  std::get<SystemStatus>(fake.kept[GetSystemStatus]).laser = LaserStatus::HeatingUp;
  const auto identity = connect();
  expect_fault(identity, TrackerFault::NotReady);
  EXPECT_THAT(identity.error().detail, HasSubstr("heating up"));
}

TEST_F(EmsconTrackerTest, IsInspectedByQuestionsAlone) {
  const auto identity = run(tracker.inspect({}));
  ASSERT_TRUE(identity) << identity.error().detail;
  EXPECT_EQ(identity->firmware, "3.8.900");
  EXPECT_THAT(fake.commands, ElementsAre(GetSystemStatus, GetReflectors, GetTrackerInfo));
}

TEST_F(EmsconTrackerTest, SaysOnInspectionWhyItCouldNotMeasure) {
  std::get<SystemStatus>(fake.kept[GetSystemStatus]).laser = LaserStatus::HeatingUp;
  expect_fault(run(tracker.inspect({})), TrackerFault::NotReady);
  fake.script(GetSystemStatus, [&] { clock.ring(); });
  expect_fault(run(tracker.inspect({})), TrackerFault::Timeout);
}

TEST_F(EmsconTrackerTest, RefusesATrackerThatDoesNotKeepItsUnits) {
  fake.script(GetUnits, [&] { fake.answer(GetUnits, 0, Units{.length = LengthUnit::Inch}); });
  const auto identity = connect();
  expect_fault(identity, TrackerFault::NotReady);
  EXPECT_THAT(identity.error().detail,
              HasSubstr("its units (it has in, rad, C, mbar, needed are mm, rad, C, mbar)"));
}

TEST_F(EmsconTrackerTest, NamesTheAddressThatNobodyAnswersAt) {
  asio::ip::tcp::acceptor unused{io, {asio::ip::address_v4::loopback(), 0}};
  const std::uint16_t port = unused.local_endpoint().port();
  unused.close();
  EmsconTracker nobody{io.get_executor(), clock, {.host = "127.0.0.1", .port = port}};
  const auto identity = run(nobody.connect({}));
  expect_fault(identity, TrackerFault::Unreachable);
  EXPECT_THAT(identity.error().detail, HasSubstr("127.0.0.1:" + std::to_string(port)));
}

TEST_F(EmsconTrackerTest, GivesUpConnectingToAMuteTrackerAtTheDeadline) {
  fake.script(SetUnits, [&] { clock.ring(); });
  expect_fault(connect(), TrackerFault::Timeout);
  fake.unscript(SetUnits);
  EXPECT_TRUE(connect());
}

TEST_F(EmsconTrackerTest, AimsByDrivingThenSearchingAndChecksTheLock) {
  ASSERT_TRUE(connect());
  fake.commands.clear();
  const auto aimed = aim(25);
  ASSERT_TRUE(aimed) << aimed.error().detail;
  EXPECT_EQ(fake.kept[GetSearchParams], (Body{SearchParams{25, 10000}}));
  ASSERT_TRUE(aim(25));
  EXPECT_EQ(count(SetSearchParams), 1) << "an unchanged radius is not written again";
  EXPECT_EQ(count(GoPosition), 2);
  EXPECT_EQ(count(FindReflector), 2);

  std::get<MeasurementStatusInfo>(fake.kept[GetMeasurementStatusInfo]).mask = kInitializedBit;
  expect_fault(aim(25), TrackerFault::NoTarget);
}

TEST_F(EmsconTrackerTest, TellsAFailedSearchFromABusyOrUninitializedTracker) {
  ASSERT_TRUE(connect());
  fake.script(FindReflector, [&] { fake.answer(FindReflector, 24999); });
  expect_fault(aim(), TrackerFault::NoTarget);
  fake.script(FindReflector, [&] { fake.send(ErrorReport{FindReflector, 24999}); });
  expect_fault(aim(), TrackerFault::NoTarget);
  fake.script(FindReflector, [&] { fake.answer(FindReflector, status::kServerBusy); });
  expect_fault(aim(), TrackerFault::Busy);
  fake.script(GoPosition, [&] { fake.answer(GoPosition, status::kNotInitialized); });
  expect_fault(aim(), TrackerFault::NotReady);
  fake.script(GoPosition, [&] { fake.answer(GoPosition, status::kInvalidInput); });
  expect_fault(aim(), TrackerFault::Refused);
}

TEST_F(EmsconTrackerTest, MeasuresWithSpreadAndWeather) {
  ASSERT_TRUE(connect());
  const auto point = measure();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_EQ(point->p_WS_mm, Eigen::Vector3d(1000, 2000, -500));
  EXPECT_EQ(point->std_mm, Eigen::Vector3d(0.005, 0.006, 0.007));
  EXPECT_EQ(point->temperature_c, 21);
  EXPECT_EQ(point->pressure_mbar, 1000);
  EXPECT_EQ(point->humidity_percent, 40);
}

TEST_F(EmsconTrackerTest, TakesTheResultBeforeOrAfterTheAnswerAndWhateverComesBetween) {
  ASSERT_TRUE(connect());
  fake.script(StartMeasurement, [&] {
    fake.event(SystemEvent::MeasurementBusy);
    fake.send(fake.result);
    fake.send(ReflectorPosResult{0, {9, 9, 9}});
    fake.send_bytes({12, 0, 0, 0, 11, 0, 0, 0, 0, 0, 0, 0});  // a 6D type that is unknown here
    fake.answer(GoPosition, 35);                              // nobody asked
    fake.answer(StartMeasurement);
  });
  expect_point();
  fake.script(StartMeasurement, [&] {
    fake.answer(StartMeasurement);
    fake.send(ReflectorPosResult{0, {9, 9, 9}});
    fake.send(SingleMeasResult2{
        .v = {1001, 2000, -500}, .std = fake.result.std, .environment = fake.result.environment});
    fake.event(SystemEvent::MeasurementReady);
  });
  expect_point(1001);
}

TEST_F(EmsconTrackerTest, ReadsPacketsThatArriveByteByByte) {
  fake.greedy = false;
  ASSERT_TRUE(connect());
  ASSERT_TRUE(aim());
  expect_point();
}

TEST_F(EmsconTrackerTest, NeverTurnsAFailedMeasurementIntoANumber) {
  ASSERT_TRUE(connect());
  const auto refused = [&](std::int32_t code) {
    fake.script(StartMeasurement, [this, code] { fake.answer(StartMeasurement, code); });
    return measure();
  };
  expect_fault(refused(status::kServerBusy), TrackerFault::Busy);
  expect_fault(refused(status::kNotInitialized), TrackerFault::NotReady);
  expect_fault(refused(status::kSystemNotReady), TrackerFault::NotReady);
  expect_fault(refused(status::kUsageConflict), TrackerFault::Refused);

  fake.script(StartMeasurement, [&] {
    fake.answer(StartMeasurement);
    fake.send(ErrorReport{StartMeasurement, status::kNoStationaryResult});
  });
  expect_fault(measure(), TrackerFault::BeamBroken);
  fake.script(StartMeasurement, [&] { fake.send(ErrorReport{CommandCode::Unknown, 31000}); });
  expect_fault(measure(), TrackerFault::BeamBroken);
  fake.script(StartMeasurement, [&] {
    fake.answer(StartMeasurement);
    fake.event(SystemEvent::MeasurementNotReady);
  });
  expect_fault(measure(), TrackerFault::BeamBroken);

  SingleMeasResult bad = fake.result;
  fake.script(StartMeasurement, [&] {
    fake.answer(StartMeasurement);
    fake.send(bad);
  });
  bad.status = status::kNoStationaryResult;
  expect_fault(measure(), TrackerFault::BeamBroken);
  bad.status = status::kMeasurementStatusNotReady;
  expect_fault(measure(), TrackerFault::NotReady);
  bad.status = 0;
  bad.v[1] = std::numeric_limits<double>::quiet_NaN();
  expect_fault(measure(), TrackerFault::Protocol);
  bad.v[1] = 0;
  bad.std[2] = std::numeric_limits<double>::infinity();
  expect_fault(measure(), TrackerFault::Refused);

  fake.unscript(StartMeasurement);
  expect_point();
}

TEST_F(EmsconTrackerTest, RefusesAirAndSpreadsThatCannotBeAndSaysWhatCan) {
  ASSERT_TRUE(connect());
  SingleMeasResult sent = fake.result;
  fake.script(StartMeasurement, [&] {
    fake.answer(StartMeasurement);
    fake.send(sent);
  });
  const auto refused = [&](double& number, double value) {
    sent = fake.result;
    number = value;
    const auto point = measure();
    expect_fault(point, TrackerFault::Refused);
    return point ? "" : point.error().detail;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double kelvin_zero : {-273.0, 1e9, nan})
    EXPECT_THAT(refused(sent.environment.temperature, kelvin_zero), HasSubstr("plausible are -20..60 C"));
  EXPECT_THAT(refused(sent.environment.temperature, -273), HasSubstr("an air temperature of -273 C"));
  for (const double vacuum : {0.0, -1.0, 1e5, nan})
    EXPECT_THAT(refused(sent.environment.pressure, vacuum), HasSubstr("plausible are 500..1100 mbar"));
  for (const double humidity : {-1.0, 101.0, nan})
    EXPECT_THAT(refused(sent.environment.humidity, humidity), HasSubstr("plausible are 0..100 %"));
  for (double& spread : sent.std) {
    for (const double value : {-1.0, 1e9, nan})
      EXPECT_THAT(refused(spread, value), HasSubstr("plausible are 0..100 mm"));
  }
  sent = fake.result;
  std::ranges::fill(sent.std, 0.0);
  const auto exact = measure();
  expect_fault(exact, TrackerFault::Refused);
  EXPECT_THAT(exact.error().detail, HasSubstr("a spread of its readings of exactly 0 mm"));
  sent = fake.result;
  expect_point();
}

TEST_F(EmsconTrackerTest, TakesTheFirstReflectorThatTheTrackerListsWhereNoneIsNamed) {
  EmsconTracker any{io.get_executor(), clock, {.host = "127.0.0.1", .port = fake.port(), .reflector = ""}};
  const auto identity = run(any.connect({}));
  ASSERT_TRUE(identity) << identity.error().detail;
  EXPECT_EQ(fake.kept[GetReflector], Body{ReflectorChoice{4}});
}

TEST_F(EmsconTrackerTest, SaysWhatToDoWithATrackerThatListsNoReflector) {
  fake.script(GetReflectors, [&] { fake.answer(GetReflectors, 0, ReflectorEntry{}); });
  const auto identity = connect();
  expect_fault(identity, TrackerFault::Refused);
  EXPECT_THAT(identity.error().detail, HasSubstr("the tracker lists no reflectors: define one"));
}

TEST_F(EmsconTrackerTest, DoesNotMeasureWithoutALock) {
  ASSERT_TRUE(connect());
  std::get<MeasurementStatusInfo>(fake.kept[GetMeasurementStatusInfo]).mask = kInitializedBit;
  expect_fault(measure(), TrackerFault::NoTarget);
  EXPECT_EQ(count(StartMeasurement), 0);
}

TEST_F(EmsconTrackerTest, DoesNotUseTheLateResultOfAMeasurementThatTimedOut) {
  ASSERT_TRUE(connect());
  fake.script(StartMeasurement, [&] {
    fake.answer(StartMeasurement);
    clock.ring();
  });
  expect_fault(measure(), TrackerFault::Timeout);

  fake.unscript(StartMeasurement);
  fake.script(StopMeasurement, [&] {
    SingleMeasResult stale = fake.result;
    stale.v[0] = -1;
    fake.send(stale);
    fake.answer(StopMeasurement);
  });
  expect_point();
  EXPECT_EQ(count(StopMeasurement), 1);
  EXPECT_EQ(fake.connections, 1);
}

TEST_F(EmsconTrackerTest, DropsATrackerThatDoesNotStopMeasuring) {
  ASSERT_TRUE(connect());
  fake.script(StartMeasurement, [&] {
    fake.answer(StartMeasurement);
    clock.ring();
  });
  expect_fault(measure(), TrackerFault::Timeout);
  fake.script(StopMeasurement, [&] { fake.answer(StopMeasurement, status::kServerBusy); });
  expect_fault(measure(), TrackerFault::Disconnected);
  fake.unscript(StartMeasurement);
  ASSERT_TRUE(connect());
  expect_point();
}

TEST_F(EmsconTrackerTest, DropsTheConnectionWhenAnAnswerStaysOut) {
  ASSERT_TRUE(connect());
  fake.script(FindReflector, [&] { clock.ring(); });
  expect_fault(aim(), TrackerFault::Timeout);
  expect_fault(measure(), TrackerFault::Disconnected);
  ASSERT_TRUE(connect());
  expect_point();
}

TEST_F(EmsconTrackerTest, ReportsAConnectionLostWhileMeasuringAndConnectsAgain) {
  ASSERT_TRUE(connect());
  fake.script(StartMeasurement, [&] {
    fake.answer(StartMeasurement);
    const auto bytes = encode(fake.result);
    fake.send_bytes({bytes.begin(), bytes.begin() + 100});
    fake.hang_up();
  });
  expect_fault(measure(), TrackerFault::Disconnected);
  expect_fault(measure(), TrackerFault::Disconnected);
  fake.unscript(StartMeasurement);
  ASSERT_TRUE(connect());
  expect_point();
}

TEST_F(EmsconTrackerTest, ClosesTheConnectionOnBytesThatAreNotEmscon) {
  ASSERT_TRUE(connect());
  fake.script(StartMeasurement, [&] { fake.send_bytes({3, 0, 0, 0, 0, 0, 0, 0}); });
  expect_fault(measure(), TrackerFault::Protocol);
  expect_fault(measure(), TrackerFault::Disconnected);
}

TEST_F(EmsconTrackerTest, RestoresWhatAnotherProgramChanged) {
  ASSERT_TRUE(connect());
  fake.script(GetMeasurementStatusInfo, [&] {
    fake.kept[GetTransformationParams] = Transformation{.shift = {100, 0, 0}};
    fake.event(SystemEvent::TransformationChanged);
    fake.unscript(GetMeasurementStatusInfo);
    fake.answer(GetMeasurementStatusInfo, 0, fake.kept[GetMeasurementStatusInfo]);
  });
  expect_point();
  EXPECT_EQ(fake.kept[GetTransformationParams], Body{Transformation{}});
  fake.commands.clear();
  expect_point();
  EXPECT_EQ(count(SetTransformationParams), 0) << "put right once is enough";
}

TEST_F(EmsconTrackerTest, RejectsAPointDuringWhichTheUnitsChanged) {
  ASSERT_TRUE(connect());
  fake.script(StartMeasurement, [&] {
    fake.kept[GetUnits] = Units{};
    fake.event(SystemEvent::UnitsChanged);
    fake.answer(StartMeasurement);
    fake.send(fake.result);
  });
  expect_fault(measure(), TrackerFault::NotReady);
  fake.unscript(StartMeasurement);
  expect_point();
  EXPECT_EQ(fake.kept[GetUnits], Body{Units{.length = LengthUnit::Millimeter}});
}

TEST_F(EmsconTrackerTest, CanBeCancelledWhileMeasuringAndMeasuresAgain) {
  ASSERT_TRUE(connect());
  fake.script(StartMeasurement, [&] {
    fake.answer(StartMeasurement);
    cancel.emit(asio::cancellation_type::terminal);
  });
  try {
    static_cast<void>(measure());
    FAIL() << "the call was not cancelled";
  } catch (const boost::system::system_error& error) {
    EXPECT_EQ(error.code(), asio::error::operation_aborted);
  }
  fake.unscript(StartMeasurement);
  expect_point();
}

TEST_F(EmsconTrackerTest, EndsACallWhenItIsDisconnectedMeanwhile) {
  ASSERT_TRUE(connect());
  fake.script(StartMeasurement, [&] { tracker.disconnect(); });
  expect_fault(measure(), TrackerFault::Disconnected);
}

}  // namespace
}  // namespace truepose::drivers
