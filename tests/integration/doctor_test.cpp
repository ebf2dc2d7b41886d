// What truepose doctor finds by its own sockets, and by a daemon that runs. Every single finding is in
// tests/tools/doctor/diagnose_test.cpp.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/json/parse.hpp>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "core/arm/forward.hpp"
#include "proto/rsi/frame_codec.hpp"
#include "tests/integration/live_cell.hpp"
#include "tests/tools/doctor/scripted_controller.hpp"

namespace truepose {
namespace {

namespace json = boost::json;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::ResultOf;

/// A finding of truepose doctor.
struct Said {
  std::string area, level, finding, next;
};
void PrintTo(const Said& said, std::ostream* out) {
  *out << said.level << ' ' << said.area << ' ' << said.finding << "; next: " << said.next << '\n';
}

auto says(const std::string& level, const std::string& area, const std::string& finding,
          const std::string& next) {
  return Contains(AllOf(ResultOf([](const Said& s) { return s.level; }, level),
                        ResultOf([](const Said& s) { return s.area; }, area),
                        ResultOf([](const Said& s) { return s.finding; }, HasSubstr(finding)),
                        ResultOf([](const Said& s) { return s.next; }, HasSubstr(next))));
}

/// What a healthy controller sends of the shipped arm.
std::string healthy_frame(const config::CellConfig& cell, std::uint64_t cycle) {
  const rsi::Axes axes{0.1, -1.5, 1.5, 0.2, 0.4, -0.3};
  const Eigen::Vector3d p_BF_mm =
      forward_kinematics(cell.robot.model, Eigen::Map<const Eigen::Vector<double, 6>>(axes.data()))
          .translation();
  const rsi::CartesianPose pose{.x_mm = p_BF_mm.x(), .y_mm = p_BF_mm.y(), .z_mm = p_BF_mm.z()};
  const rsi::RobotFrame frame{.ipoc = 4 * cycle,
                              .rist = pose,
                              .rsol = pose,
                              .aipos_rad = axes,
                              .aspos_rad = axes,
                              .delay = 0,
                              .program = {.ask = 1,
                                          .state = rsi::kProgramActive,
                                          .mode = rsi::kModeExt,
                                          .override_percent = 100,
                                          .cell = 1024}};
  std::array<char, rsi::kMaxFrameBytes> buffer;
  return std::string{encode_robot_frame(frame, buffer).value()};
}

class TheDoctor : public testing::Test {
 protected:
  void send_healthy_frames(std::uint16_t port) {
    controller = std::make_unique<ScriptedController>(
        port, [config = config::load_cell(cell.cell_file())](std::uint64_t cycle) {
          return healthy_frame(config, cycle);
        });
  }
  std::vector<Said> asked() const {
    const Finished doctor = run_program("truepose", {"doctor", "--cell", cell.cell_file(), "--json"});
    std::vector<Said> said;
    const json::value findings = json::parse(doctor.out);
    for (const json::value& one : findings.as_array()) {
      const auto text = [&](const char* key) { return std::string{one.at(key).as_string()}; };
      said.push_back({text("area"), text("level"), text("finding"), text("next")});
    }
    const bool fault = std::ranges::any_of(said, [](const Said& one) { return one.level == "fault"; });
    EXPECT_EQ(doctor.exit_code, fault ? 1 : 0) << doctor.err;
    return said;
  }

  LiveCell cell;
  std::unique_ptr<ScriptedController> controller;
};

TEST_F(TheDoctor, FindsNoFaultInAHealthyCellButThatItsDaemonDoesNotRun) {
  send_healthy_frames(cell.rsi_port());
  const auto said = asked();
  EXPECT_THAT(said, says("ok", "rsi", "sends good frames", ""));
  EXPECT_THAT(said, says("ok", "robot", "#KR210R2700_2 C4 FLR, serial 210001", ""));
  EXPECT_THAT(said, says("ok", "tracker", "can measure", ""));
  EXPECT_THAT(said, says("fault", "daemon", "cannot be reached", "trueposed --config"));
}

TEST_F(TheDoctor, NamesThePortThatTheControllerSendsToInstead) {
  if (::geteuid() != 0) GTEST_SKIP() << "root alone sees packets to other ports";
  const std::uint16_t other = free_udp_port();
  send_healthy_frames(other);
  const auto said = asked();
  EXPECT_THAT(said,
              says("fault", "rsi", "sends RSI packets to 127.0.0.1:" + std::to_string(other), "IP_NUMBER"));
  EXPECT_THAT(said, testing::Not(says("warning", "rsi", "no RSI packet comes to 127.0.0.1:", "RSI_ON")));
}

TEST_F(TheDoctor, AsksTheDaemonThatRuns) {
  cell.start_daemon();
  const auto said = asked();
  EXPECT_THAT(said, says("ok", "daemon", "runs, state disconnected", ""));
  EXPECT_THAT(said, says("ok", "robot", "serial 210001", ""));
}

TEST_F(TheDoctor, TellsTheDaemonOfAnotherCellFromItsOwn) {
  cell.start_daemon();
  std::string text = text_of(cell.cell_file());
  text.replace(text.find("name: demo"), 10, "name: press_shop");
  cell.write("cell.yaml", text);
  const auto said = asked();
  EXPECT_THAT(said, says("fault", "daemon", "is that of cell demo, not of press_shop", "start it"));
  EXPECT_THAT(said, says("fault", "rsi", "in use by trueposed", "end that process"));
}

}  // namespace
}  // namespace truepose
