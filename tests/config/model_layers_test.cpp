// What a model file holds beyond geometry: masses, deviations of the joints and the residual field.
#include <gtest/gtest.h>

#include "config/model_file.hpp"
#include "core/arm/forward.hpp"
#include "core/arm/guide.hpp"
#include "core/field/gaussian_process.hpp"
#include "core/fit/regression_field.hpp"
#include "core/math/random.hpp"
#include "tests/config/error_of.hpp"

namespace truepose::config {
namespace {

JointVector random_joints(Random& random, int joints) {
  JointVector q(joints);
  for (double& position : q) position = random.uniform(-2, 2);
  return q;
}

/// Six revolute joints with every kind of deviation, and masses.
RobotModel deviating_arm(Random& random) {
  const auto any = [&] { return random.uniform(-1, 1); };
  RobotModel robot;
  robot.name = "six";
  for (int i = 0; i < 6; ++i) {
    robot.joints.push_back(
        {.a_mm = 300 * any(), .alpha_rad = any(), .d_mm = 300 * any(), .theta_rad = any()});
    robot.masses.push_back({.mass_kg = 100 + 50 * any(), .centre_mm = {100 * any(), 100 * any(), any()}});
  }
  robot.torque_joints = robot.joints;
  robot.torque_joints[2].a_mm += 1;
  robot.gravity_B = Eigen::Vector3d(any(), any(), any()).normalized();
  robot.deviation = {{.joint = 0, .basis = DeviationBasis::Sine, .order = 162, .coefficient = 1e-3 * any()},
                     {.joint = 1, .basis = DeviationBasis::Cosine, .order = 2, .coefficient = 1e-3 * any()},
                     {.joint = 2, .basis = DeviationBasis::Gravity, .order = 1, .coefficient = 1e-3 * any()},
                     {.joint = 3, .basis = DeviationBasis::Weight, .order = 7, .coefficient = 1e-3 * any()},
                     {.joint = 4, .basis = DeviationBasis::Approach, .order = 1, .coefficient = 1e-3 * any()},
                     {.joint = 5, .basis = DeviationBasis::Scale, .order = 1, .coefficient = 1e-3 * any()}};
  return robot;
}

std::shared_ptr<const RegressionField> random_field(const RobotModel& robot, int poses, int targets,
                                                    Random& random) {
  RegressionData data{.X = Eigen::MatrixXd(poses, field_features(robot)),
                      .Y = Eigen::MatrixXd(poses, targets)};
  for (double& x : data.X.reshaped()) x = random.uniform(-1, 1);
  for (double& y : data.Y.reshaped()) y = random.uniform(-0.1, 0.1);
  const auto regressor = fit_regressor(kGaussianProcess, data);
  if (!regressor) throw std::runtime_error(regressor.error());
  return std::make_shared<RegressionField>(robot, *regressor, Eigen::Vector3d(60, -40, 1.0 / 3));
}

ModelFile model_of(const RobotModel& robot) { return {.name = "six", .cell = {.robot = robot}}; }

void expect_same_poses(const RobotModel& read, const RobotModel& robot, Random& random) {
  const std::vector<std::int8_t> direction{1, -1, 0, 1, -1, 1};
  for (int k = 0; k < 50; ++k) {
    const JointVector q = random_joints(random, robot.joint_count());
    EXPECT_EQ(forward_kinematics(read, q, direction).matrix(),
              forward_kinematics(robot, q, direction).matrix());
  }
}

TEST(ModelLayers, MassesAndDeviationsComeBackToTheLastBit) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random{seed};
    const RobotModel robot = deviating_arm(random);
    const RobotModel read = parse_model(model_yaml(model_of(robot)), "m.yaml").cell.robot;
    EXPECT_EQ(read.deviation, robot.deviation);
    EXPECT_EQ(read.gravity_B, robot.gravity_B);
    ASSERT_EQ(read.torque_joints.size(), 6U);
    EXPECT_EQ(read.torque_joints[2].a_mm, robot.torque_joints[2].a_mm);
    expect_same_poses(read, robot, random);
  }
}

/// On a rail whose carriage errs in every way.
RobotModel railed_arm(Random& random) {
  RobotModel robot = deviating_arm(random);
  robot.joints[0].type = JointType::Prismatic;
  robot.joints[0].min = -2.5;
  robot.joints[0].max = 1.0 / 3;
  robot.deviation.erase(robot.deviation.begin());
  for (const GuideMotion& motion : kGuideMotions)
    robot.deviation.push_back(
        {.joint = 0, .basis = motion.basis, .order = 5, .coefficient = random.uniform(-0.1, 0.1)});
  return robot;
}

TEST(ModelLayers, TheGuideOfARailComesBackToTheLastBit) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random{seed};
    const RobotModel robot = railed_arm(random);
    const RobotModel read = parse_model(model_yaml(model_of(robot)), "m.yaml").cell.robot;
    EXPECT_EQ(read.deviation, robot.deviation);
    expect_same_poses(read, robot, random);
  }
}

TEST(ModelLayers, AFieldPredictsTheSameToTheLastBit) {
  for (const int targets : {3, 6}) {
    Random random{7};
    RobotModel robot = deviating_arm(random);
    robot.field = random_field(robot, 30, targets, random);
    const RobotModel read = parse_model(model_yaml(model_of(robot)), "m.yaml").cell.robot;
    ASSERT_TRUE(read.field);
    expect_same_poses(read, robot, random);
  }
}

TEST(ModelLayers, AModelOfGeometryAloneHasNone) {
  RobotModel robot;
  robot.name = "one";
  robot.joints.resize(1);
  const RobotModel read = parse_model(model_yaml(model_of(robot)), "m.yaml").cell.robot;
  EXPECT_TRUE(read.masses.empty());
  EXPECT_TRUE(read.torque_joints.empty());
  EXPECT_TRUE(read.deviation.empty());
  EXPECT_FALSE(read.field);
}

class ModelLayersErrors : public testing::Test {
 protected:
  ModelLayersErrors() {
    Random random{3};
    RobotModel robot = deviating_arm(random);
    robot.field = random_field(robot, 5, 3, random);
    text_ = model_yaml(model_of(robot));
  }
  /// Without the place, which the fixed ones show.
  std::string error_with(const std::string& from, const std::string& to) const {
    std::string text = text_;
    const auto at = text.find(from);
    if (at == std::string::npos) return "not there: " + from;
    text.replace(at, from.size(), to);
    std::string error = error_of([&] { parse_model(text, "m.yaml"); }, "");
    const auto path = error.find(": robot");
    return path == std::string::npos ? error : error.substr(path + 2);
  }
  std::string text_;
};

TEST_F(ModelLayersErrors, RefusesATermOfAJointOrFrameThatTheArmHasNot) {
  EXPECT_EQ(error_with("{joint: 1, basis: sine", "{joint: 0, basis: sine"),
            "robot.non_geometric[1].joint: expected 1..6, found 0");
  EXPECT_EQ(error_with("{joint: 1, basis: sine", "{joint: 7, basis: sine"),
            "robot.non_geometric[1].joint: expected 1..6, found 7");
  EXPECT_EQ(error_with("  non_geometric:", "  deviation:"),
            "robot.deviation: unknown key, renamed to 'non_geometric'");
  EXPECT_EQ(error_with("order: 162", "order: 0"),
            "robot.non_geometric[1].order: expected 1..100000, found 0");
  EXPECT_EQ(error_with("weight, order: 7", "weight, order: 8"),
            "robot.non_geometric[4].order: expected 1..7, found 8");
  EXPECT_EQ(
      error_with("basis: sine", "basis: sin"),
      "robot.non_geometric[1].basis: expected one of sine, cosine, gravity, weight, moment-x, moment-y, "
      "moment-z, approach, scale, shift-x, turn-x, shift-y, turn-y, turn-z, found "
      "'sin'");
}

TEST_F(ModelLayersErrors, RefusesAGuideOfAJointThatDoesNotSlideAndOfMoreThanThree) {
  EXPECT_EQ(error_with("{joint: 1, basis: sine", "{joint: 1, basis: shift-x"),
            "robot.non_geometric[1]: a guide is that of a prismatic joint with a way from min to max");
  Random random{3};
  RobotModel robot = railed_arm(random);
  for (const std::size_t i : {1U, 2U, 3U}) {
    robot.joints[i] = robot.joints[0];
    robot.deviation.push_back({.joint = static_cast<int>(i), .basis = DeviationBasis::TurnY});
  }
  text_ = model_yaml(model_of(robot));
  EXPECT_EQ(error_with("", ""), "robot.non_geometric[13]: expected guides of at most 3 joints");
  robot.joints[0].max = robot.joints[0].min;
  text_ = model_yaml(model_of(robot));
  EXPECT_EQ(error_with("", ""),
            "robot.non_geometric[6]: a guide is that of a prismatic joint with a way from min to max");
}

TEST_F(ModelLayersErrors, RefusesMassesThatAreNotOnePerJointAndAGravityThatIsNoDirection) {
  EXPECT_EQ(error_with("  masses:\n", "  masses:\n    - {kg: 1, x: 0, y: 0, z: 0}\n"),
            "robot.masses: expected 6, one per joint, found 7");
  EXPECT_EQ(error_with("  gravity: {x: ", "  gravity: {x: 9"),
            "robot.gravity: expected a direction of length 1");
}

TEST_F(ModelLayersErrors, RefusesAFieldWhoseNumbersDoNotFit) {
  EXPECT_EQ(error_with("kind: gp", "kind: spline"), "robot.field.kind: expected one of gp, found 'spline'");
  EXPECT_EQ(error_with("    y:\n", "    y:\n      - [1, 2]\n"),
            "robot.field.y[1]: expected 3 or 6 numbers, found 2");
  EXPECT_EQ(error_with("    y:\n", "    y:\n      - [1, 2, 3, 4, 5, 6]\n"),
            "robot.field.y[2]: expected 6 numbers as in the first row, found 3");
  EXPECT_EQ(error_with("    y:\n", "    y:\n      - [1, 2, 3]\n"),
            "robot.field: features, targets and groups of a residual field must be as many");
  EXPECT_EQ(error_with("noise_ratio: ", "weight: "),
            "robot.field: residual field gp: hyper-parameter noise_ratio is missing");
}

}  // namespace
}  // namespace truepose::config
