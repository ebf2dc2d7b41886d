#include "config/robot_fix.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "config/robot_file.hpp"
#include "config/text_file.hpp"
#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

constexpr char kArm[] = R"(# An arm with notes.
name: two   # of them
joints:
  - {a: 0, alpha: 0, d: 100, theta: 0, sign: -1, min: -180, max: 180, speed: 90}   # turns
  - a: 10
    alpha: 90
    d:   5
    theta: 0
    sign: 1
    min: -90
    max: 90
    speed: 50
flange: {x: 0, y: 0, z: 0, a: 0, b: 0, c: 0}   # fixed
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

class RobotFix : public testing::Test {
 protected:
  /// The text of `text`, fixed to the robot that `change` makes of it.
  std::string fixed(const std::string& text, auto change) {
    const auto file = folder_.write("robot.yaml", text);
    RobotModel robot = load_robot(file);
    change(robot);
    return fixed_robot_text(file, robot);
  }
  TempFolder folder_;
};

TEST_F(RobotFix, ChangesNumbersAndNothingElse) {
  EXPECT_EQ(fixed(kArm, [](RobotModel& r) { r.joints[0].sign = 1; }), replaced(kArm, "sign: -1", "sign: 1"));
  EXPECT_EQ(fixed(kArm, [](RobotModel& r) { r.joints[1].theta_rad = -std::numbers::pi / 2; }),
            replaced(kArm, "theta: 0\n", "theta: -90\n"));
  EXPECT_EQ(fixed(kArm, [](RobotModel& r) { std::swap(r.joints[1].a_mm, r.joints[1].d_mm); }),
            replaced(replaced(kArm, "a: 10", "a: 5"), "d:   5", "d:   10"));
  EXPECT_EQ(fixed(kArm, [](RobotModel& r) { r.X_flange.translation().z() = 12.5; }),
            replaced(kArm, "z: 0", "z: 12.5"));
  EXPECT_EQ(fixed(kArm, [](RobotModel&) {}), kArm);
}

TEST_F(RobotFix, AddsWhatTheFileDidNotSay) {
  const auto bent = [](RobotModel& r) {
    for (Joint& joint : r.joints) joint.beta_rad = std::numbers::pi / 6;
  };
  EXPECT_EQ(fixed(kArm, bent), replaced(replaced(kArm, "{a: 0, alpha", "{beta: 30, a: 0, alpha"), "- a: 10",
                                        "- beta: 30\n    a: 10"));
  const auto coupled = [](RobotModel& r) { r.coupling = {{1, 0, -1}}; };
  EXPECT_EQ(fixed(kArm, coupled),
            replaced(kArm, "flange", "coupling: [{joint: 2, to: 1, factor: -1}]\nflange"));
  const std::string without_flange{kArm, std::string_view{kArm}.find("flange")};
  EXPECT_EQ(fixed(without_flange, [](RobotModel& r) { r.X_flange.translation().x() = 7; }),
            without_flange + "flange: {x: 7, y: 0, z: 0, a: 0, b: 0, c: 0}\n");
}

TEST_F(RobotFix, RefusesAFileWhoseJointsShareTheirNumbers) {
  const auto file =
      folder_.write("robot.yaml",
                    "name: two\njoints:\n"
                    "  - &one {a: 0, alpha: 0, d: 1, theta: 0, sign: 1, min: 0, max: 1, speed: 1}\n"
                    "  - *one\n");
  RobotModel robot = load_robot(file);
  robot.joints[1].sign = -1;
  EXPECT_EQ(error_of([&] { fixed_robot_text(file, robot); }, file),
            "robot.yaml: cannot be changed in place: write out what it says by aliases, then try again");
}

TEST_F(RobotFix, SaysInWhichLineAValueStands) {
  const std::string file = folder_.write("robot.yaml", kArm);
  EXPECT_EQ(robot_place(file, 0, "sign"), file + ":4:46: joints[1].sign");
  EXPECT_EQ(robot_place(file, 1, "theta"), file + ":8:12: joints[2].theta");
  EXPECT_EQ(robot_place(file, 1, "beta"), file + ":5:5: joints[2]");
  EXPECT_EQ(robot_place(file, -1, "coupling"), file + ":4:3: joints");
}

}  // namespace
}  // namespace truepose::config
