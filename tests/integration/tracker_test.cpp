#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json/value.hpp>
#include <string>

#include "tests/integration/live_cell.hpp"
#include "tests/integration/sqlite_rows.hpp"
#include "tests/process.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;

const std::string kNests =
    "[{x: 1500, y: -1400, z: -800}, {x: 1800, y: 1500, z: -700}, {x: 3200, y: -1300, z: -1200}, {x: 2500, y: 1600, z: 600}]";
const std::string kThinAir = "{temperature_c: 34, pressure_mbar: 790, humidity_percent: 65}";
const std::string kOfScenario = "  reflector: CCR-1.5in                # how it names the reflector type";
const std::string kOfCell = "  beam_radius_mm: 25 ";

/// A tracker without a weather station, that errs in its directions and slips on its tripod at its 40th
/// point.
LiveCell::Options odd_tracker() {
  return {
      .speedup = 1000,
      .faults = "[{at_point: 40, kind: tracker-bump, by_mm: {x: 0.2, y: 0.3, z: 0}}]",
      .scenario = {{kOfScenario,
                    kOfScenario + "\n  weather_station: false\n  true_air: " + kThinAir +
                        "\n  aiming_urad: {collimation: 60, tilt: -90, index: 45}\n  nests_mm: " + kNests}},
      .cell = {{kOfCell, "  nests: " + kNests + "\n  air: " + kThinAir + "\n" + kOfCell},
               {"two_face_every: 0 ", "two_face_every: 3 "},
               {"nests_every: 10 ", "nests_every: 6 "}}};
}

TEST(ACampaignWithAnOddTracker, PutsRightWhatNestsFacesAndAirTellAndSaysSo) {
  LiveCell cell{odd_tracker()};
  cell.start_daemon();
  // What was measured while it slipped is left out, and enough is left to validate by.
  const Finished campaign =
      cell.truepose({"campaign", "start", "--identify", "12", "--validate", "12", "--remeasure", "--watch"});
  ASSERT_EQ(campaign.exit_code, 0) << campaign.err << campaign.out << cell.daemon().errors();
  const Finished report = cell.truepose({"report"});
  EXPECT_THAT(report.out, HasSubstr("of the nests the tracker moved: it stands 0.3"));
  EXPECT_THAT(report.out, HasSubstr("in one face the tracker errs by up to 0."));
  using Rows = std::vector<std::vector<std::string>>;
  EXPECT_EQ(
      sqlite_rows(cell.store_file(), "SELECT count(*) >= 7 FROM point WHERE purpose='nest' AND smr='nest 4'"),
      (Rows{{"1"}}));
  EXPECT_EQ(sqlite_rows(cell.store_file(), "SELECT min(pressure_mbar), max(pressure_mbar) FROM point"),
            (Rows{{"790.0", "790.0"}}));
  EXPECT_EQ(sqlite_rows(cell.store_file(), "SELECT active FROM model"), (Rows{{"1"}})) << report.out;
}

}  // namespace
}  // namespace truepose
