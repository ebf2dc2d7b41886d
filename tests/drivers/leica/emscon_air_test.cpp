#include <gmock/gmock.h>

#include "tests/drivers/leica/emscon_fixture.hpp"

namespace truepose::drivers {
namespace {

using namespace emscon;
using enum CommandCode;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

/// A driver that gets the air.
class EmsconAirTest : public EmsconTrackerTest {
 protected:
  EmsconAirTest() {
    EmsconOptions with_air = options;
    with_air.air = [this] { return air; };
    driver.emplace(io.get_executor(), clock, with_air);
  }
  auto connect_with_air() { return run(driver->connect({})); }
  auto measure_with_air() { return run(driver->measure({})); }
  double index_of_adm() { return std::get<Refraction>(fake.kept[GetRefractionParams]).adm_index; }

  std::expected<Air, std::string> air = Air{20, 1013.25, 50};
  std::optional<EmsconTracker> driver;
};

TEST_F(EmsconAirTest, TellsTheTrackerTheAirAndItsRefraction) {
  const auto identity = connect_with_air();
  ASSERT_TRUE(identity) << identity.error().detail;
  EXPECT_EQ(fake.kept[GetEnvironmentParams], (Body{Environment{20, 1013.25, 50}}));
  // As Ciddor's equation has them for the phase at 633 nm and for the group at 795 nm.
  EXPECT_NEAR(std::get<Refraction>(fake.kept[GetRefractionParams]).ifm_index, 1.000271373, 1e-8);
  EXPECT_NEAR(index_of_adm(), 1.000274859, 1e-8);
  EXPECT_EQ(std::get<SystemSettings>(fake.kept[GetSystemSettings]).weather, WeatherMonitor::NotConnected);
}

TEST_F(EmsconAirTest, WritesAnIndexFarOffBeforeTheRightOneForTrackersThatIgnoreSmallChanges) {
  double kept = 1.0003;
  fake.script(SetRefractionParams, [&] {
    const auto& wanted = std::get<Refraction>(fake.latest.body);
    if (std::abs(wanted.adm_index - kept) > 1e-6) kept = wanted.adm_index;
    fake.answer(SetRefractionParams);
    fake.kept[GetRefractionParams] = Refraction{wanted.ifm_index, kept};
  });
  ASSERT_TRUE(connect_with_air());
  air->temperature_c = 20.5;
  ASSERT_TRUE(measure_with_air());
  EXPECT_NEAR(index_of_adm(), 1.000274859 - 0.48e-6, 2e-8);
}

TEST_F(EmsconAirTest, WritesNewAirBeforeTheNextPoint) {
  ASSERT_TRUE(connect_with_air());
  const double before = index_of_adm();
  ASSERT_TRUE(measure_with_air());
  EXPECT_EQ(index_of_adm(), before);
  air->pressure_mbar = 963.25;
  const auto point = measure_with_air();
  ASSERT_TRUE(point) << point.error().detail;
  EXPECT_NEAR(index_of_adm() - before, -50 * 0.27e-6, 0.5e-6);
  EXPECT_EQ(fake.kept[GetEnvironmentParams], (Body{Environment{20, 963.25, 50}}));
}

TEST_F(EmsconAirTest, PutsItsAirBackWhereAnotherProgramHasChangedIt) {
  ASSERT_TRUE(connect_with_air());
  const double index = index_of_adm();
  fake.kept[GetRefractionParams] = Refraction{1.0002, 1.0002};
  fake.script(GetMeasurementStatusInfo, [this] {
    fake.event(SystemEvent::RefractionChanged);
    fake.unscript(GetMeasurementStatusInfo);
    fake.answer(GetMeasurementStatusInfo, 0, fake.kept[GetMeasurementStatusInfo]);
  });
  ASSERT_TRUE(measure_with_air());
  EXPECT_EQ(index_of_adm(), index);
}

TEST_F(EmsconAirTest, MeasuresNothingWhileNobodyKnowsTheAir) {
  ASSERT_TRUE(connect_with_air());
  air = std::unexpected("air.yaml: was written 7200 s ago");
  const auto point = measure_with_air();
  expect_fault(point, TrackerFault::NotReady);
  EXPECT_THAT(point.error().detail, HasSubstr("air.yaml: was written 7200 s ago"));
  EXPECT_THAT(fake.commands, Not(Contains(StartMeasurement)));
}

TEST_F(EmsconAirTest, LeavesTheAirToATrackerThatKnowsIt) {
  ASSERT_TRUE(connect());
  EXPECT_THAT(fake.commands, Not(Contains(SetEnvironmentParams)));
  EXPECT_THAT(fake.commands, Not(Contains(SetRefractionParams)));
}

}  // namespace
}  // namespace truepose::drivers
