#include "config/robot_file.hpp"

#include <gtest/gtest.h>

#include "core/kinematics/angles.hpp"
#include "core/kinematics/forward.hpp"
#include "tests/config/error_of.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::config {
namespace {

constexpr char kTwoJoints[] = R"(name: two
joints:
  - {a: 0, alpha: 0, d: 100, theta: 0, beta: 0, sign: -1, min: -180, max: 180, speed: 90}
  - {type: prismatic, a: 10, alpha: 90, d: 5, theta: 0, beta: 0, sign: 1, min: 0, max: 400, speed: 50}
)";

class RobotFile : public testing::Test {
 protected:
  RobotModel load(const std::string& text) { return load_robot(folder_.write("robot.yaml", text)); }
  std::string error(const std::string& text) {
    const auto file = folder_.write("robot.yaml", text);
    return error_of([&] { load_robot(file); }, file);
  }
  /// The file of two joints with the first `from` replaced.
  std::string error_with(const std::string& from, const std::string& to) {
    std::string text = kTwoJoints;
    text.replace(text.find(from), from.size(), to);
    return error(text);
  }
  TempFolder folder_;
};

TEST_F(RobotFile, ConvertsDegreesOfRevoluteAndKeepsMillimetresOfPrismaticJoints) {
  const RobotModel robot = load(kTwoJoints);
  ASSERT_EQ(robot.joint_count(), 2);
  EXPECT_EQ(robot.name, "two");
  EXPECT_EQ(robot.joints[0].type, JointType::Revolute);
  EXPECT_EQ(robot.joints[0].sign, -1);
  EXPECT_DOUBLE_EQ(robot.joints[0].max, std::numbers::pi);
  EXPECT_DOUBLE_EQ(robot.joints[0].speed, std::numbers::pi / 2);
  EXPECT_EQ(robot.joints[1].type, JointType::Prismatic);
  EXPECT_DOUBLE_EQ(robot.joints[1].alpha_rad, std::numbers::pi / 2);
  EXPECT_EQ(robot.joints[1].max, 400);
  EXPECT_EQ(robot.joints[1].speed, 50);
  EXPECT_TRUE(robot.X_flange.isApprox(Eigen::Isometry3d::Identity()));
}

TEST_F(RobotFile, ReadsTheFlangeAsAKukaPose) {
  const RobotModel robot = load(std::string(kTwoJoints) + "flange: {x: 1, y: 2, z: 3, a: 90, b: 0, c: 0}\n");
  EXPECT_TRUE(robot.X_flange.isApprox(pose_from_kuka({1, 2, 3}, {90, 0, 0})));
}

TEST_F(RobotFile, RefusesAnUnknownKeyAndSuggestsTheNearest) {
  EXPECT_EQ(error_with("theta: 0", "tehta: 0"),
            "robot.yaml:3:30: joints[1].tehta: unknown key, did you mean 'theta'?");
  EXPECT_EQ(error_with("name: two", "name: two\ncolour: red"), "robot.yaml:2:1: colour: unknown key");
}

TEST_F(RobotFile, RefusesADuplicateKeyAtItsSecondPlace) {
  EXPECT_EQ(error_with("beta: 0", "d: 7"),
            "robot.yaml:3:40: joints[1].d: duplicate key, first given in line 3");
  EXPECT_EQ(error(std::string(kTwoJoints) + "name: three\n"),
            "robot.yaml:5:1: name: duplicate key, first given in line 1");
}

TEST_F(RobotFile, NamesTheLineOfAJointWithoutD) {
  EXPECT_EQ(error_with("d: 5, ", ""), "robot.yaml:4:5: joints[2]: missing key 'd'");
}

TEST_F(RobotFile, RefusesWhatIsNoPlainDecimalNumber) {
  EXPECT_EQ(error_with("d: 100", "d: 0100"),
            "robot.yaml:3:25: joints[1].d: expected a number, found a number with a leading zero: '0100'");
  EXPECT_EQ(error_with("d: 100", "d: 0x10"),
            "robot.yaml:3:25: joints[1].d: expected a number, found not a number: '0x10'");
  EXPECT_EQ(error_with("d: 100", "d: .nan"),
            "robot.yaml:3:25: joints[1].d: expected a number, found not a number: '.nan'");
  EXPECT_EQ(error_with("d: 100", "d: -inf"),
            "robot.yaml:3:25: joints[1].d: expected a number, found not a finite number: '-inf'");
  EXPECT_EQ(error_with("d: 100", "d: 1e999"),
            "robot.yaml:3:25: joints[1].d: expected a number, found a number out of range: '1e999'");
  EXPECT_EQ(error_with("d: 100", "d: \"100\""),
            "robot.yaml:3:25: joints[1].d: expected a number, found the text '100'");
  EXPECT_EQ(error_with("d: 100", "d: "), "robot.yaml:3:22: joints[1].d: expected a number, found nothing");
  EXPECT_EQ(error_with("d: 100", "d: [1]"), "robot.yaml:3:25: joints[1].d: expected a number, found a list");
  EXPECT_EQ(error_with("d: 100", "d: 645 mm"),
            "robot.yaml:3:25: joints[1].d: expected a number, found not a number: '645 mm'");
}

TEST_F(RobotFile, ChecksSignLimitsAndSpeed) {
  EXPECT_EQ(error_with("sign: -1", "sign: 0"), "robot.yaml:3:55: joints[1].sign: expected -1 or 1, found 0");
  EXPECT_EQ(error_with("sign: -1", "sign: 0.5"),
            "robot.yaml:3:55: joints[1].sign: expected a whole number, found 0.5");
  EXPECT_EQ(error_with("min: -180", "min: 181"), "robot.yaml:3:64: joints[1].min: expected less than max");
  EXPECT_EQ(error_with("speed: 90", "speed: 0"), "robot.yaml:3:87: joints[1].speed: expected more than 0");
  EXPECT_EQ(error_with("theta: 0", "theta: 400"),
            "robot.yaml:3:37: joints[1].theta: expected -360..360, found 400");
  EXPECT_EQ(error_with("type: prismatic", "type: linear"),
            "robot.yaml:4:12: joints[2].type: expected one of revolute, prismatic, found 'linear'");
}

TEST_F(RobotFile, NeedsBetweenOneAndSixteenJoints) {
  EXPECT_EQ(error("name: none\njoints: []\n"), "robot.yaml:2:9: joints: expected 1..16 joints, found 0");
  std::string text = "name: many\njoints:\n";
  for (int i = 0; i < 17; ++i)
    text += "  - {a: 0, alpha: 0, d: 1, theta: 0, sign: 1, min: 0, max: 1, speed: 1}\n";
  EXPECT_EQ(error(text), "robot.yaml:3:3: joints: expected 1..16 joints, found 17");
}

TEST_F(RobotFile, SaysWhereTheTextIsNotYaml) {
  EXPECT_EQ(error("name: [1\n"), "robot.yaml:2:1: not valid YAML: end of sequence flow not found");
  EXPECT_EQ(error(""), "robot.yaml:1:1: the file is empty");
  EXPECT_EQ(error("name: a\n---\nname: b\n"), "robot.yaml:3:1: a second document, expected one");
  EXPECT_EQ(error("- 1\n"), "robot.yaml:1:1: expected a map of keys, found a list");
  EXPECT_EQ(error("name: &a [*a]\njoints: *a\n"), "robot.yaml:1:7: too many or too deeply nested values");
  EXPECT_NE(error(std::string(20'000, '[')), "");
}

TEST_F(RobotFile, SaysWhyAFileCannotBeOpened) {
  const auto file = folder_.path() / "none.yaml";
  EXPECT_EQ(error_of([&] { load_robot(file); }, file),
            "none.yaml: cannot be opened: No such file or directory");
  const auto parent = folder_.path();
  EXPECT_EQ(error_of([&] { load_robot(parent); }, parent),
            parent.filename().string() + ": is a folder, expected a file");
}

TEST_F(RobotFile, SurvivesTruncationAtEveryLength) {
  const std::string text = kTwoJoints;
  for (std::size_t length = 0; length < text.size(); ++length) {
    const auto file = folder_.write("robot.yaml", text.substr(0, length));
    try {
      load_robot(file);
    } catch (const ConfigError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace truepose::config
