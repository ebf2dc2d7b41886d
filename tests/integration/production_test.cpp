#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <boost/json/serialize.hpp>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "config/model_file.hpp"
#include "core/math/angles.hpp"
#include "tests/await.hpp"
#include "tests/integration/live_cell.hpp"

// A program of the cell's own under an armed stream, as processes over loopback. The whole of it, with all
// that befalls a shift, is in virtual time in tests/daemon/production_test.cpp.

namespace truepose {
namespace {

namespace json = boost::json;

constexpr const char* kProgram = R"(DEF GLUING()
   DECL INT I
   BAS(#INITMOV,0)
   $VEL.CP=0.5
   $ACC.CP=2.0
   $BASE={X 1350.0,Y -300.0,Z 800.0,A 0.0,B 0.0,C 0.0}
   $TOOL={X 30.0,Y 0.0,Z 220.0,A 0.0,B 10.0,C 0.0}
   PTP {A1 0.0,A2 -80.0,A3 105.0,A4 5.0,A5 60.0,A6 0.0}
   TP_BEGIN()
   FOR I=0 TO 2
      LIN {X 100.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 180.0}
      WAIT SEC 0.35
      CIRC {X 150.0,Y 50.0,Z 20.0},{X 100.0,Y 100.0,Z 40.0,A 0.0,B 0.0,C 180.0}
      WAIT SEC 0.35
   ENDFOR
   TP_END()
END
)";

struct Point {
  double gain_percent = 0, with_mm = 0, without_mm = 0;
};

/// The points at which the arm stood, of a path file.
std::vector<Point> points_of(const std::filesystem::path& file, const CalibratedCell& found) {
  std::ifstream in{file};
  std::vector<Point> points;
  std::string line;
  for (std::getline(in, line); std::getline(in, line);) {
    std::vector<double> row;
    std::istringstream fields{line};
    for (std::string field; std::getline(fields, field, ',');) row.push_back(std::atof(field.c_str()));
    const auto at = [&row](std::size_t i) { return Eigen::Vector3d{row[i], row[i + 1], row[i + 2]}; };
    const Eigen::Isometry3d X_BF = pose_from_kuka(at(4), at(7));
    const Eigen::Vector3d wanted_W = found.base.isometry() * (X_BF * found.reflectors.at(0).p_FS_mm);
    if (row[2] == 1) points.push_back({row[3], (at(10) - wanted_W).norm(), (at(13) - wanted_W).norm()});
  }
  return points;
}

class AProductionProgram : public testing::Test {
 protected:
  void begin() {
    const std::string shipped = TRUEPOSE_SOURCE_DIR "/config/scenarios/gluing";
    LiveCell::Options options{.speedup = 1000, .patient = true};
    options.scenario = {{shipped + ".src, " + shipped + ".dat", folder.write("gluing.src", kProgram)}};
    cell.emplace(options);
    cell->start_daemon();
    const Finished campaign = cell->truepose({"campaign", "start", "--watch"});
    ASSERT_EQ(campaign.exit_code, 0) << campaign.err << cell->daemon().errors();
    const auto model = cell->client().call("model.export", {});
    found = config::parse_model(model.value().at("yaml").as_string().c_str(), "exported").cell;
    const Finished armed = cell->truepose({"stream", "arm"});
    ASSERT_EQ(armed.exit_code, 0) << armed.err;
  }
  void select() {
    ASSERT_EQ(cell->steer({{"kind", "program-select"}, {"program", "GLUING"}}), json::value({{"ok", true}}));
  }
  std::string state() const { return std::string{cell->steer({{"ask", "program"}}).at("state").as_string()}; }
  void wait_until(const std::string& wanted) {
    await(
        "the program's state is " + wanted, [&] { return state() == wanted; }, [&] { return state(); });
  }

  /// From the next start of the daemon on.
  void lose_state_server() {
    std::ifstream in{cell->cell_file()};
    const std::string text{std::istreambuf_iterator<char>{in}, {}};
    static const std::regex kAddress{"eki_state: [0-9.:]+"};
    ASSERT_TRUE(std::regex_search(text, kAddress));
    cell->write("cell.yaml", std::regex_replace(text, kAddress, "eki_state: 127.0.0.1:9"));
  }
  /// That RSI tells, and all else of the robot's state.
  void wait_for_emergency_stop(bool pressed) {
    tools::RpcClient client = cell->client();
    json::value robot;
    await(
        std::string{"RSI tells of "} + (pressed ? "an" : "no") + " emergency stop",
        [&] {
          robot = client.call("stream.status", {}).value().at("robot");
          return robot.at("emergency_stop") == pressed;
        },
        [&] { return json::serialize(robot); });
    EXPECT_EQ(robot.at("unknown"), "");
    EXPECT_EQ(robot.at("gate_open"), false);
  }

  std::vector<Point> points() const {
    state();  // the file is written when the cell is asked something
    return points_of(cell->path_file(), found);
  }
  void wait_for_points(std::size_t count) const {
    await("the arm stood at " + std::to_string(count) + " points", [&] { return points().size() >= count; });
  }

  TempFolder folder;
  std::optional<LiveCell> cell;
  CalibratedCell found;
};

TEST_F(AProductionProgram, GoesOnCorrectedBehindAnEmergencyStopAndADaemonThatWasKilled) {
  begin();
  select();
  wait_until("active");
  wait_for_points(2);
  cell->steer({{"kind", "emergency-stop"}});  // until it is released
  wait_until("stopped");
  cell->daemon().send(SIGKILL);
  cell->daemon().wait();
  lose_state_server();
  cell->start_daemon();
  wait_for_emergency_stop(true);
  cell->steer({{"kind", "emergency-stop"}, {"lasts_ms", 1000}});
  wait_for_emergency_stop(false);
  wait_until("ended");
  const json::value rsi = cell->simulated().at("rsi");
  EXPECT_LE(number(rsi, "/max_step_deg"), kMaxStep_deg);
  EXPECT_EQ(number(rsi, "/correction_at_end_deg"), 0) << "ramped out before RSI was closed";
  EXPECT_EQ(rsi.at("sessions"), 1);
  const std::vector<Point> all = points();
  int judged = 0;
  for (const Point& point : all) {
    if (point.gain_percent < 100) continue;
    ++judged;
    EXPECT_LT(point.with_mm, 0.2);
    EXPECT_GT(point.without_mm, 1);
  }
  EXPECT_GE(judged, 5);
  EXPECT_EQ(all.back().gain_percent, 100);
}

}  // namespace
}  // namespace truepose
