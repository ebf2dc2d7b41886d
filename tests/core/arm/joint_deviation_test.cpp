#include "core/arm/joint_deviation.hpp"

#include <gtest/gtest.h>

#include "core/arm/forward.hpp"
#include "core/arm/robot_model.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "tests/core/two_joints.hpp"

namespace truepose {
namespace {

/// Two links of one metre in a vertical plane: joint 1 turns about the horizontal y axis of the base.
RobotModel pendulum() {
  RobotModel robot;
  robot.joints = {{.alpha_rad = -90 * kRadPerDeg}, {.a_mm = 1000}};
  robot.X_flange.translation().x() = 1000;
  return robot;
}

TEST(JointDeviation, AnArmWithoutTermsStandsWhereItsEncodersSay) {
  EXPECT_EQ(true_joints(pendulum(), two_joints(0.3, -0.2)), two_joints(0.3, -0.2));
}

TEST(JointDeviation, TermsAddUpPerJoint) {
  RobotModel robot = pendulum();
  robot.deviation = {{0, DeviationBasis::Sine, 2, 1e-3},
                     {0, DeviationBasis::Cosine, 1, 2e-3},
                     {1, DeviationBasis::Approach, 1, 5e-4}};
  const std::vector<std::int8_t> approach{1, -1};
  const JointVector q = two_joints(0.3, -0.2), at = true_joints(robot, q, approach);
  EXPECT_DOUBLE_EQ(at[0], 0.3 + 1e-3 * std::sin(0.6) + 2e-3 * std::cos(0.3));
  EXPECT_DOUBLE_EQ(at[1], -0.2 - 5e-4);
  EXPECT_DOUBLE_EQ(true_joints(robot, q)[1], -0.2) << "an unknown approach takes no side";
}

TEST(JointDeviation, AStretchedArmSagsUnderItsWeight) {
  RobotModel robot = pendulum();
  robot.masses = {{.mass_kg = 100, .centre_mm = {500, 0, 0}}, {.mass_kg = 50, .centre_mm = {500, 0, 0}}};
  robot.deviation = {{0, DeviationBasis::Gravity, 1, 1e-3}, {1, DeviationBasis::Gravity, 1, 2e-3}};
  const JointVector at = true_joints(robot, two_joints(0, 0));
  const double kilonewtons = 9.80665e-3;
  EXPECT_NEAR(at[0], 1e-3 * kilonewtons * (100 * 0.5 + 50 * 1.5), 1e-15);
  EXPECT_NEAR(at[1], 2e-3 * kilonewtons * 50 * 0.5, 1e-15);
  EXPECT_LT(forward_kinematics(robot, two_joints(0, 0)).translation().z(), -1e-3) << "down is where it goes";
  EXPECT_NEAR(true_joints(robot, two_joints(-90 * kRadPerDeg, 0))[0], -90 * kRadPerDeg, 1e-15)
      << "upright there is no lever";
}

TEST(JointDeviation, APayloadPullsAtTheFlangeWhetherOrNotTheMassesAreKnown) {
  RobotModel robot = pendulum();
  robot.deviation = {{0, DeviationBasis::Gravity, 1, 1e-3}, {1, DeviationBasis::Gravity, 1, 2e-3}};
  EXPECT_EQ(true_joints(robot, two_joints(0, 0)), two_joints(0, 0)) << "nothing is known to pull";
  robot.payload = LinkMass{.mass_kg = 20, .centre_mm = {300, 0, 0}};
  const double kilonewtons = 9.80665e-3;
  EXPECT_NEAR(true_joints(robot, two_joints(0, 0))[0], 1e-3 * kilonewtons * 20 * 2.3, 1e-15);
  EXPECT_NEAR(true_joints(robot, two_joints(0, 0))[1], 2e-3 * kilonewtons * 20 * 1.3, 1e-15);
  robot.masses = {{}, {.mass_kg = 50, .centre_mm = {500, 0, 0}}};
  EXPECT_NEAR(true_joints(robot, two_joints(0, 0))[1], 2e-3 * kilonewtons * (20 * 1.3 + 50 * 0.5), 1e-15);
}

TEST(JointDeviation, AUnitWeightPullsWhereItHangs) {
  RobotModel robot = pendulum();
  robot.deviation = {{0, DeviationBasis::Weight, 2, 1.0}, {0, DeviationBasis::Weight, 3, 1.0}};
  std::vector<double> basis(2);
  deviation_basis(robot, two_joints(0, 90 * kRadPerDeg), {}, basis);
  EXPECT_NEAR(basis[0], 1.0, 1e-12) << "the elbow stands one metre out";
  EXPECT_NEAR(basis[1], 1.0, 1e-12) << "and the flange hangs below it";
  robot.gravity_B = {0, 0, 1};
  deviation_basis(robot, two_joints(0, 0), {}, basis);
  EXPECT_NEAR(basis[1], -2.0, 1e-12) << "an arm that hangs from the ceiling";
}

TEST(JointDeviation, EachTermHasItsNameAmongTheParameters) {
  CalibratedCell cell{pendulum(), {}, {{"1", {}}}};
  cell.robot.deviation = {
      {1, DeviationBasis::Sine, 2}, {0, DeviationBasis::Gravity}, {0, DeviationBasis::Weight, 3}};
  const auto names = parameter_names(cell);
  ASSERT_EQ(names.size(), static_cast<std::size_t>(ParameterLayout::of(cell).size()));
  EXPECT_EQ((std::vector(names.end() - 3, names.end())),
            (std::vector<std::string>{"joint2.sin2", "joint1.gravity", "joint1.weight3"}));
}

TEST(JointDeviation, DerivativesToTheCoefficientsAreThoseOfDifferences) {
  CalibratedCell cell{pendulum(), {{100, 200, 300}, {0.1, 0.2, 0.3}}, {{"1", {50, 60, 70}}}};
  cell.robot.joints.push_back({.type = JointType::Prismatic, .alpha_rad = 0.7, .sign = -1});
  cell.robot.deviation = {{0, DeviationBasis::Sine, 2, 1e-3},
                          {1, DeviationBasis::Cosine, 1, 1e-3},
                          {1, DeviationBasis::Weight, 4, 2e-3},
                          {0, DeviationBasis::Approach, 1, 1e-3},
                          {2, DeviationBasis::Scale, 1, 0.02}};
  const JointVector q = (JointVector(3) << 0.4, -0.9, 250).finished();
  const std::vector<std::int8_t> approach{-1, 1, 0};
  PointJacobian J;
  const Eigen::Vector3d p = predict_with_jacobian(cell, q, 0, J, approach);
  EXPECT_LT((p - cell.predict(q, 0, approach)).norm(), 1e-10);
  const ParameterLayout layout = ParameterLayout::of(cell);
  for (int t = 0; t < layout.deviations; ++t) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(layout.size());
    step[layout.deviation(t)] = 1e-5;
    const Eigen::Vector3d difference =
        (moved(cell, step).predict(q, 0, approach) - moved(cell, -step).predict(q, 0, approach)) / 2e-5;
    EXPECT_LT((J.col(layout.deviation(t)) - difference).norm(), 1e-6 * difference.norm()) << t;
    EXPECT_GT(difference.norm(), 0.1) << t;
  }
}

TEST(ResidualField, DisplacesTheFlangeThatTheParametersPredict) {
  class Lift final : public ResidualField {
    Eigen::Isometry3d displaced(const JointVector& q, const Eigen::Isometry3d& X_BF) const noexcept override {
      return Eigen::Translation3d(0, 0, q[0]) * X_BF;
    }
    Eigen::Matrix3d covariance(const JointVector&, const Eigen::Isometry3d&,
                               const Eigen::Vector3d&) const override {
      return Eigen::Matrix3d::Zero();
    }
  };
  RobotModel robot = pendulum();
  const double z = forward_kinematics(robot, two_joints(0.5, 0)).translation().z();
  robot.field = std::make_shared<Lift>();
  EXPECT_NEAR(forward_kinematics(robot, two_joints(0.5, 0)).translation().z(), z + 0.5, 1e-12);
  EXPECT_NEAR(forward_with_jacobian(robot, two_joints(0.5, 0)).X_BF.translation().z(), z + 0.5, 1e-12);
}

}  // namespace
}  // namespace truepose
