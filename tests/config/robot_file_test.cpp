#include "config/robot_file.hpp"

#include <gtest/gtest.h>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
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

TEST_F(RobotFile, ReadsCouplingsByTheNumbersOfTheJoints) {
  std::string text = kTwoJoints;
  text.replace(text.find("type: prismatic, "), 17, "");
  const RobotModel robot = load(text + "coupling: [{joint: 2, to: 1}]\n");
  EXPECT_EQ(robot.coupling, (std::vector<JointCoupling>{{.joint = 1, .to = 0, .factor = 1}}));
  EXPECT_EQ(load(text + "coupling: [{joint: 2, to: 1, factor: -0.5}]\n").coupling[0].factor, -0.5);
}

TEST_F(RobotFile, RefusesACouplingThatNoArmHas) {
  const auto wrong = [&](const std::string& coupling) {
    return error(std::string(kTwoJoints) + "coupling: [" + coupling + "]\n");
  };
  EXPECT_EQ(wrong("{joint: 1, to: 2}"),
            "robot.yaml:5:11: coupling: joint 1 to 2: expected a joint before it");
  EXPECT_EQ(wrong("{joint: 2, to: 1}"),
            "robot.yaml:5:11: coupling: joint 2 to 1: expected joints of the arm that turn");
  EXPECT_EQ(wrong("{joint: 7, to: 1}"),
            "robot.yaml:5:11: coupling: joint 7 to 1: expected joints of the arm that turn");
}

std::string with_masses(const std::string& more = "") {
  std::string text = kTwoJoints;
  text.replace(text.find("speed: 90"), 9, "speed: 90, mass: {kg: 20, x: 1, y: 2, z: 3}");
  text.replace(text.find("speed: 50"), 9, "speed: 50, mass: {kg: 10, x: 100, y: 0, z: -40}");
  return text + more;
}

TEST_F(RobotFile, MayStateTheMassOfEveryJoint) {
  EXPECT_TRUE(load(kTwoJoints).masses.empty());
  const RobotModel robot = load(with_masses());
  ASSERT_EQ(robot.masses.size(), 2U);
  EXPECT_EQ(robot.masses[0].mass_kg, 20);
  EXPECT_EQ(robot.masses[0].centre_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(robot.masses[1].centre_mm, Eigen::Vector3d(100, 0, -40));
}

TEST_F(RobotFile, NamesTheJointWhoseMassIsMissing) {
  EXPECT_EQ(error_with("speed: 90", "speed: 90, mass: {kg: 20, x: 1, y: 2, z: 3}"),
            "robot.yaml:4:5: joints[2]: missing key 'mass': give one to every joint or to none");
  EXPECT_EQ(error_with("speed: 90", "speed: 90, mass: {kg: 20, x: 1, y: 2}"),
            "robot.yaml:3:97: joints[1].mass: missing key 'z'");
  EXPECT_EQ(error_with("speed: 90", "speed: 90, mass: {kg: -1, x: 1, y: 2, z: 3}"),
            "robot.yaml:3:102: joints[1].mass.kg: expected 0..1e+05, found -1");
}

TEST_F(RobotFile, ThePayloadHangsOnTheFlange) {
  const RobotModel robot = load(with_masses("payload: {kg: 30, x: 20, y: 0, z: 60}\n"));
  EXPECT_EQ(robot.payload, (LinkMass{30, {20, 0, 60}}));
  EXPECT_EQ(robot.masses[1].mass_kg, 10);
  EXPECT_EQ(error(std::string(kTwoJoints) + "payload: {kg: 30, x: 20, y: 0, z: 60}\n"),
            "robot.yaml:5:10: payload: expected a mass for every joint too");
}

TEST_F(RobotFile, GravityIsADirectionOfAnyLength) {
  EXPECT_EQ(load(kTwoJoints).gravity_B, Eigen::Vector3d(0, 0, -1));
  const RobotModel wall = load(std::string(kTwoJoints) + "gravity: {x: 3, y: 0, z: -4}\n");
  EXPECT_LT((wall.gravity_B - Eigen::Vector3d(0.6, 0, -0.8)).norm(), 1e-15);
  EXPECT_EQ(error(std::string(kTwoJoints) + "gravity: {x: 0, y: 0, z: 0}\n"),
            "robot.yaml:5:10: gravity: a direction of no length");
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
