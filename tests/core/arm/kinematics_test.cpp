#include <gtest/gtest.h>

#include "core/arm/forward.hpp"
#include "core/arm/pose_inverse.hpp"
#include "core/arm/spherical_wrist.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/math/angles.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/golden.hpp"
#include "tests/core/pose_differences.hpp"

namespace truepose {
namespace {

RobotModel golden_robot(const std::string& set) {
  const auto fk = golden::load("fk");
  const auto& entry = fk.at("parameter_sets").at(set);
  return golden::robot(entry.at("links"), entry.at("sign"));
}

TEST(ForwardKinematics, ReproducesTheGoldenPosesOfEveryParameterSet) {
  const auto fk = golden::load("fk");
  for (const std::string set : {"nominal", "perturbed", "table1_literal"}) {
    const RobotModel robot = golden_robot(set);
    for (const auto& item : fk.at("cases").as_array()) {
      const Eigen::MatrixXd expected = golden::matrix(item.at(set));
      const Eigen::Isometry3d X = forward_kinematics(robot, golden::vector(item.at("q")));
      EXPECT_LT((X.translation() - expected.topRightCorner<3, 1>()).norm(), 1e-9) << set;
      EXPECT_LT((X.linear() - expected.topLeftCorner<3, 3>()).cwiseAbs().maxCoeff(), 1e-12) << set;
    }
  }
}

TEST(ForwardKinematics, PredictsTheGoldenPointsInTheTrackerFrame) {
  const auto fk = golden::load("fk");
  const CalibratedCell cell = golden::cell(golden_robot("perturbed"), fk.at("base"), fk.at("tool"));
  for (const auto& item : fk.at("cases").as_array()) {
    const Eigen::Vector3d expected = golden::vector(item.at("perturbed_point"));
    EXPECT_LT((cell.predict(golden::vector(item.at("q")), 0) - expected).norm(), 1e-9);
  }
}

TEST(ForwardKinematics, PutsTheHomeFlangeWhereTheDataSheetDoes) {
  JointVector q(6);
  q << 0, -90, 90, 0, 0, 0;
  const Eigen::Isometry3d X = forward_kinematics(golden_robot("nominal"), q * kRadPerDeg);
  EXPECT_LT((X.translation() - Eigen::Vector3d(1765, 0, 1910)).norm(), 1e-9);
  Eigen::Matrix3d axes;
  axes << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  EXPECT_LT((X.linear() - axes).norm(), 1e-12);
}

TEST(JointJacobian, AgreesWithDifferencesForRevoluteAndPrismaticJoints) {
  Random random{7};
  for (const RobotModel& robot : {golden_robot("perturbed"), example::oblique_arm_on_a_rail()}) {
    const JointVector q = example::random_joints(robot, random);
    const PoseAndJacobian at = forward_with_jacobian(robot, q);
    EXPECT_LT((at.X_BF.matrix() - forward_kinematics(robot, q).matrix()).norm(), 1e-11);
    expect_differences(robot, q, at);
  }
}

TEST(Angles, SurviveTheGimbalAndEveryQuadrant) {
  for (const double b : {90., -90., 89.9999999, 180., 0., -30.}) {
    for (const double a : {0., 45., -170., 180.}) {
      const Eigen::Matrix3d R = pose_from_kuka({0, 0, 0}, {a, b, 20}).linear();
      const Eigen::Matrix3d back = pose_from_kuka({0, 0, 0}, kuka_abc_deg(R)).linear();
      EXPECT_LT((R - back).norm(), 1e-12) << a << " " << b;
    }
  }
}

TEST(SphericalWristInverse, FindsEightBranchesThatAllReachThePose) {
  const RobotModel robot = golden_robot("nominal");
  const auto inverse = SphericalWristInverse::of(robot);
  ASSERT_TRUE(inverse) << inverse.error();
  Random random{11};
  int eights = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const JointVector q = example::random_joints(robot, random);
    const Eigen::Isometry3d X = forward_kinematics(robot, q);
    const auto solutions = inverse->all(X, q);
    eights += solutions.count == 8;
    double nearest = 1e9;
    for (int k = 0; k < solutions.count; ++k) {
      const JointVector& s = solutions.q.at(static_cast<std::size_t>(k));
      EXPECT_LT((forward_kinematics(robot, s).matrix() - X.matrix()).norm(), 1e-8);
      JointVector turn = s - q;
      for (double& t : turn) t = std::remainder(t, 2 * std::numbers::pi);
      nearest = std::min(nearest, turn.norm());
    }
    EXPECT_LT(nearest, 1e-6) << "the branch that the pose came from is among them";
    const auto same = inverse->nearest(X, q);
    ASSERT_TRUE(same) << same.error();
    EXPECT_LT((*same - q).norm(), 1e-6) << "and with the turns of the axes it is the nearest";
  }
  EXPECT_GT(eights, 500);
}

TEST(SphericalWristInverse, KeepsAxisFourInTheWristSingularity) {
  const RobotModel robot = golden_robot("nominal");
  JointVector q(6);
  q << 10, -80, 90, 37, 0, -12;
  q *= kRadPerDeg;
  const auto back = SphericalWristInverse::of(robot)->nearest(forward_kinematics(robot, q), q);
  ASSERT_TRUE(back);
  EXPECT_LT((*back - q).norm(), 1e-6);
}

TEST(SphericalWristInverse, SaysWhyAnArmHasNoClosedFormOrAPoseNoSolution) {
  RobotModel robot = golden_robot("nominal");
  const auto inverse = SphericalWristInverse::of(robot);
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation() = Eigen::Vector3d(5000, 0, 0);
  EXPECT_EQ(inverse->nearest(far, JointVector::Zero(6)).error(), "the pose is out of the arm's reach");
  robot.joints[4].a_mm = 3;
  EXPECT_EQ(SphericalWristInverse::of(robot).error(),
            "no closed-form inverse for KR 210 R2700-2: axes 4, 5 and 6 do not meet in a point");
}

TEST(PoseInverse, ReproducesTheGoldenCompensatedJoints) {
  const auto golden = golden::load("compensate");
  const RobotModel nominal = golden::robot(golden.at("nominal_links"), golden.at("sign"));
  const RobotModel perturbed = golden::robot(golden.at("perturbed_links"), golden.at("sign"));
  Eigen::Isometry3d X_FT = Eigen::Isometry3d::Identity();
  X_FT.translation() = golden::vector(golden.at("tool"));
  for (const auto& item : golden.at("cases").as_array()) {
    Eigen::Isometry3d X_BT;
    X_BT.matrix() = golden::matrix(item.at("target_tool_pose"));
    const JointVector q_nominal = golden::vector(item.at("q_nominal"));
    const auto solution = inverse_near(perturbed, X_BT * X_FT.inverse(), q_nominal);
    ASSERT_TRUE(solution);
    EXPECT_LT((solution->q - golden::vector(item.at("q_compensated"))).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LE(solution->iterations, 6);
    const auto compensated = TargetCompensation(nominal, perturbed).at_joints(q_nominal);
    ASSERT_TRUE(compensated);
    EXPECT_LT((compensated->q - golden::vector(item.at("q_compensated"))).cwiseAbs().maxCoeff(), 1e-10);
  }
}

TEST(PoseInverse, ConvergesFromFiveDegreesOffAndOnARedundantArm) {
  Random random{13};
  for (const RobotModel& robot : {golden_robot("perturbed"), example::oblique_arm_on_a_rail()}) {
    for (int trial = 0; trial < 500; ++trial) {
      const JointVector q = example::random_joints(robot, random);
      JointVector seed = q;
      for (double& s : seed) s += 5 * kRadPerDeg * random.uniform(-1, 1);
      const Eigen::Isometry3d X = forward_kinematics(robot, q);
      const auto solution = inverse_near(robot, X, seed);
      ASSERT_TRUE(solution) << trial;
      EXPECT_LT((forward_kinematics(robot, solution->q).translation() - X.translation()).norm(), 1e-8);
    }
  }
}

TEST(PoseInverse, NeverReturnsANumberForAPoseOutOfReachOrNotFinite) {
  const RobotModel robot = golden_robot("nominal");
  JointVector q(6);
  q << 0, -90, 90, 0, 10, 0;
  Eigen::Isometry3d X = forward_kinematics(robot, q * kRadPerDeg);
  X.translation().x() += 5000;
  EXPECT_EQ(inverse_near(robot, X, q * kRadPerDeg).error(), PoseInverseFault::DidNotConverge);
  X.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(inverse_near(robot, X, q * kRadPerDeg).error(), PoseInverseFault::NotFinite);
}

}  // namespace
}  // namespace truepose
