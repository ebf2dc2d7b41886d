#include "config/air_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

constexpr char kAirText[] = "{temperature_c: 23.5, pressure_mbar: 968, humidity_percent: 41}\n";

class AirFile : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) { return folder_.write("air.yaml", text); }
  std::string error(const std::string& text) {
    const auto file = write(text);
    return error_of([&] { load_air(file); }, file);
  }
  TempFolder folder_;
};

TEST_F(AirFile, HoldsAllThreeAndNothingElse) {
  EXPECT_EQ(load_air(write(kAirText)), (Air{23.5, 968, 41}));
  EXPECT_EQ(load_air(write(R"({"temperature_c": 23.5, "pressure_mbar": 968, "humidity_percent": 41})")),
            (Air{23.5, 968, 41}));
  EXPECT_THAT(error("{temperature_c: 23.5, pressure_mbar: 968}\n"), HasSubstr("humidity_percent"));
  EXPECT_THAT(error("{temperature_c: 23.5, pressure_mbar: 968, humidity_percent: 41, wind: 3}\n"),
              HasSubstr("wind"));
}

TEST_F(AirFile, RefusesAnotherUnitOfPressure) {
  EXPECT_THAT(error("{temperature_c: 23.5, pressure_mbar: 101325, humidity_percent: 41}\n"),
              HasSubstr("air.yaml:1:38: pressure_mbar"));
}

TEST_F(AirFile, IsReadAgainEachTime) {
  const auto source = air_source({.air_file = write(kAirText)});
  ASSERT_TRUE(source().has_value());
  EXPECT_EQ(source()->temperature_c, 23.5);
  write("{temperature_c: 24.5, pressure_mbar: 968, humidity_percent: 41}\n");
  EXPECT_EQ(source()->temperature_c, 24.5);
}

TEST_F(AirFile, IsNoAirOnceItIsTooOld) {
  const auto file = write(kAirText);
  std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now() - 2h);
  const auto air = air_source({.air_file = file})();
  ASSERT_FALSE(air);
  EXPECT_THAT(air.error(), HasSubstr("air.yaml: was written 7200 s ago, allowed are 3600 s"));
  EXPECT_TRUE(air_source({.air_file = file, .air_max_age = 3h})());
}

TEST_F(AirFile, IsNoAirWhereItIsDatedLaterThanNow) {
  const auto file = write(kAirText);
  const auto dated = [&](std::chrono::seconds ahead) {
    std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now() + ahead);
    return air_source({.air_file = file})();
  };
  EXPECT_TRUE(dated(30s)) << "clocks of two machines differ";
  const auto air = dated(24h);
  ASSERT_FALSE(air);
  EXPECT_THAT(air.error(), HasSubstr("air.yaml: is dated 86"));
  EXPECT_THAT(air.error(), HasSubstr("set the clocks of this PC and of the weather station"));
}

TEST_F(AirFile, ThatIsNotThereOrBrokenIsSaidInWords) {
  EXPECT_THAT(air_source({.air_file = folder_.path() / "none.yaml"})().error(),
              HasSubstr("none.yaml: cannot be read"));
  EXPECT_THAT(air_source({.air_file = write("{")})().error(), HasSubstr("air.yaml:"));
}

TEST(AirSource, IsWhatWasEnteredOrNobody) {
  EXPECT_EQ(*air_source({.air = Air{21, 1000, 30}})(), (Air{21, 1000, 30}));
  EXPECT_FALSE(air_source({}));
}

}  // namespace
}  // namespace truepose::config
