#include <gtest/gtest.h>

#include "core/arm/arm_kernel.hpp"
#include "core/arm/spherical_wrist.hpp"
#include "core/arm/status_turn.hpp"
#include "core/calibrate/calibrate.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/plan/scene.hpp"
#include "core/simulate/true_arm.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/pose_differences.hpp"

namespace truepose {
namespace {

/// The flange by one matrix after the other, joint 3 turned by what the controller shows of joints 2 and 3.
Eigen::Isometry3d by_hand(const RobotModel& arm, const JointVector& q) {
  const auto turned = [](double angle, const Eigen::Vector3d& axis) {
    return Eigen::Isometry3d{Eigen::AngleAxisd(angle, axis)};
  };
  const auto moved = [](double x, double z) { return Eigen::Isometry3d{Eigen::Translation3d(x, 0, z)}; };
  const double angle[] = {q[0], q[1], q[2] + q[1], q[3], q[4], q[5]};
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < 6; ++i) {
    const Joint& joint = arm.joints[i];
    X = X * turned(joint.beta_rad, Eigen::Vector3d::UnitY()) *
        turned(joint.alpha_rad, Eigen::Vector3d::UnitX()) * moved(joint.a_mm, 0) *
        turned(joint.theta_rad + joint.sign * angle[i], Eigen::Vector3d::UnitZ()) * moved(0, joint.d_mm);
  }
  return X * arm.X_flange;
}

RobotModel deviating_arm(Random& random) { return example::deviating(example::lr_mate(), random, 0.5, 2e-3); }

/// An arm whose couplings follow on each other, by factors of both signs.
RobotModel coupled_twice() {
  RobotModel arm = example::kr210();
  arm.coupling = {{.joint = 4, .to = 3, .factor = -0.5},
                  {.joint = 2, .to = 1, .factor = -1},
                  {.joint = 5, .to = 3, .factor = 0.25},
                  {.joint = 5, .to = 4, .factor = 2}};
  return arm;
}

double apart(const Eigen::Isometry3d& A, const Eigen::Isometry3d& B) {
  return (A.matrix() - B.matrix()).norm();
}

TEST(JointCoupling, KeepsTheForearmLevelWhereTheControllerCountsFromTheHorizon) {
  const RobotModel arm = example::lr_mate();
  JointVector q = JointVector::Zero(6);
  const Eigen::Isometry3d X = forward_kinematics(arm, q);
  EXPECT_LT((X.translation() - Eigen::Vector3d(50 + 335 + 80, 0, 330 + 330 + 35)).norm(), 1e-9);
  q[1] = 0.3;
  EXPECT_LT((forward_kinematics(arm, q).linear() - X.linear()).norm(), 1e-12);
}

TEST(JointCoupling, EveryForwardKinematicsIsTheProductOfMatrices) {
  Random random{31};
  const RobotModel arm = deviating_arm(random);
  const ArmKernel kernel{arm};
  Eigen::ArrayXXd q_all(100, 6);
  PoseColumns columns(100, 12);
  for (Eigen::Index n = 0; n < 100; ++n) q_all.row(n) = example::random_joints(arm, random).transpose();
  kernel.forward(q_all, columns);
  for (Eigen::Index n = 0; n < 100; ++n) {
    const JointVector q = q_all.row(n).transpose();
    const Eigen::Isometry3d X = by_hand(arm, q);
    LinkFrames frames;
    link_frames(arm, q, frames);
    EXPECT_LT(apart(forward_kinematics(arm, q), X), 1e-9);
    EXPECT_LT(apart(frames[6] * arm.X_flange, X), 1e-9);
    EXPECT_LT(apart(kernel.forward(q), X), 1e-9);
    EXPECT_LT((columns.row(n).segment<3>(9).matrix().transpose() - X.translation()).norm(), 1e-9);
  }
}

TEST(JointCoupling, JacobiansAreDerivativesToTheControllersJoints) {
  Random random{32};
  for (const RobotModel& arm : {deviating_arm(random), coupled_twice()}) {
    const JointVector q = example::random_joints(arm, random);
    const PoseAndJacobian slow = forward_with_jacobian(arm, q);
    PoseAndJacobian fast;
    ArmKernel{arm}.forward_with_jacobian(q, fast);
    EXPECT_LT((slow.J - fast.J).norm(), 1e-9);
    expect_differences(arm, q, slow);
  }
}

TEST(JointCoupling, EveryInverseLeadsBackToThePose) {
  Random random{33};
  const RobotModel arm = example::lr_mate();
  const auto closed_form = SphericalWristInverse::of(arm);
  ASSERT_TRUE(closed_form) << closed_form.error();
  for (int trial = 0; trial < 200; ++trial) {
    const JointVector q = example::random_joints(arm, random);
    const Eigen::Isometry3d X = by_hand(arm, q);
    const auto solutions = closed_form->all(X, q);
    ASSERT_GT(solutions.count, 0);
    for (std::size_t k = 0; k < static_cast<std::size_t>(solutions.count); ++k)
      EXPECT_LT(apart(by_hand(arm, solutions.q.at(k)), X), 1e-8);
    const auto nearest = closed_form->nearest(X, q);
    ASSERT_TRUE(nearest) << nearest.error();
    EXPECT_LT((*nearest - q).norm(), 1e-6);
    const auto newton = inverse_near(arm, X, q + JointVector::Constant(6, 0.02));
    if (std::abs(q[4]) < 0.2) continue;  // the wrist singularity
    ASSERT_TRUE(newton);
    EXPECT_LT(apart(by_hand(arm, newton->q), X), 1e-8);
  }
}

TEST(JointCoupling, StatusAndTurnLeadToTheAxesThatTheControllerShows) {
  Random random{34};
  const RobotModel arm = example::lr_mate();
  const auto inverse = StatusTurnInverse::of(arm);
  ASSERT_TRUE(inverse) << inverse.error();
  for (int trial = 0; trial < 200; ++trial) {
    const JointVector q = example::random_joints(arm, random);
    const StatusTurn bits = inverse->of_joints(q);
    const auto back = inverse->solve(by_hand(arm, q), bits.status, bits.turn, std::nullopt);
    ASSERT_TRUE(back) << back.error();
    EXPECT_LT((*back - q).norm(), 1e-6);
  }
}

TEST(JointCoupling, OfPartOfATurnHasNoClosedForm) {
  EXPECT_EQ(SphericalWristInverse::of(coupled_twice()).error(),
            "no closed-form inverse for KR 210 R2700-2: joint 5 is coupled by a factor that is not whole");
}

TEST(JointCoupling, CompensatedJointsAreTheControllers) {
  Random random{35};
  const RobotModel nominal = example::lr_mate();
  for (int trial = 0; trial < 100; ++trial) {
    const RobotModel real = deviating_arm(random);
    JointVector q = example::random_joints(nominal, random);
    q[4] = 0.8;
    q[1] *= 0.9;
    const auto found = TargetCompensation(nominal, real).at_joints(q);
    if (!found) continue;  // at a limit or a singularity
    EXPECT_LT(apart(by_hand(real, found->q), by_hand(nominal, q)), 1e-6);
  }
}

TEST(JointCoupling, NextToTheWristSingularityThePositionIsKept) {
  Random random{36};
  const RobotModel nominal = example::lr_mate(), real = deviating_arm(random);
  JointVector q(6);
  q << 0.2, 0.3, -0.1, 0.4, 0.01, -0.3;
  const auto found = TargetCompensation(nominal, real).at_joints(q);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->damped);
  EXPECT_LT((by_hand(real, found->q).translation() - by_hand(nominal, q).translation()).norm(), 1e-6);
}

TEST(JointCoupling, TheArmIsIdentifiedFromWhatTheProductOfMatricesSays) {
  Random random{37};
  const RobotModel real = deviating_arm(random);
  const CalibratedCell truth = example::placed(real, random);
  MeasurementData data{.smr_names = {"1"}, .points = {}};
  for (int k = 0; k < 60; ++k) {
    const JointVector q = example::random_joints(real, random);
    data.points.push_back(
        {.q = q,
         .p_WS_mm = truth.base.isometry() * (by_hand(real, q) * truth.reflectors[0].p_FS_mm),
         .set = k < 40 ? PoseSet::Identify : PoseSet::Validate});
  }
  const auto found = calibrate(example::lr_mate(), data);
  ASSERT_TRUE(found) << found.error().detail;
  EXPECT_EQ(found->rank, 27);
  EXPECT_LT(found->validate->after.max, 1e-6);
  EXPECT_EQ(found->cell.robot.coupling, real.coupling);
}

TEST(JointCoupling, AGearThatDeviatesMovesItsOwnJointOfTheChainAlone) {
  RobotModel arm = example::lr_mate();
  arm.deviation = {{.joint = 1, .basis = DeviationBasis::Sine, .order = 1, .coefficient = 1e-3},
                   {.joint = 2, .basis = DeviationBasis::Sine, .order = 1, .coefficient = 2e-3}};
  JointVector q(6);
  q << 0.1, 0.4, 0.3, 0.2, -0.5, 0.6;
  RobotModel moved = example::lr_mate();
  moved.joints[1].theta_rad += 1e-3 * std::sin(q[1]);
  moved.joints[2].theta_rad -= 2e-3 * std::sin(q[2] + q[1]);
  EXPECT_LT(apart(forward_kinematics(arm, q), by_hand(moved, q)), 1e-9);
  const auto back = inverse_near(arm, by_hand(moved, q), JointVector::Zero(6));
  ASSERT_TRUE(back);
  EXPECT_LT(apart(forward_kinematics(arm, back->q), by_hand(moved, q)), 1e-8);

  CalibratedCell cell{arm, {}, {{"1", {10, 20, 30}}}};
  const Measurement point{.q = q, .p_WS_mm = by_hand(moved, q) * Eigen::Vector3d(10, 20, 30)};
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  PointJacobian J_slow;
  residuals_with_jacobian(cell, {&point, 1}, f, J);
  predict_with_jacobian(cell, q, 0, J_slow);
  EXPECT_LT(f.norm(), 1e-9);
  EXPECT_LT((J - J_slow).norm(), 1e-9 * J.norm());
}

TEST(JointCoupling, AHeavyForearmBendsTheSameHoweverItsAngleIsShown) {
  RobotModel coupled = example::lr_mate(), plain = coupled;
  plain.coupling.clear();
  NonGeometricErrors errors{.masses = std::vector<LinkMass>(6, LinkMass{5, {100, 20, 30}}),
                            .drives = std::vector<DriveError>(6, DriveError{.compliance_rad_per_Nm = 1e-6}),
                            .gravity_B_mps2 = {0, 0, -9.8}};
  JointVector q(6), q_plain(6);
  q << 0.1, 0.4, 0.3, 0.2, -0.5, 0.6;
  q_plain << 0.1, 0.4, 0.7, 0.2, -0.5, 0.6;
  const JointVector bent = q + joint_displacement(coupled, errors, q, {});
  const JointVector bent_plain = q_plain + joint_displacement(plain, errors, q_plain, {});
  EXPECT_LT(apart(forward_kinematics(coupled, bent), forward_kinematics(plain, bent_plain)), 1e-9);
}

TEST(JointCoupling, AWayOfTheJointsMovesTheArmAtMostAsFarAsItsCheckerSays) {
  Random random{38};
  Scene scene{.robot = coupled_twice()};
  PoseChecker checker{scene};
  for (int trial = 0; trial < 200; ++trial) {
    const JointVector q = example::random_joints(scene.robot, random);
    JointVector way = JointVector::NullaryExpr(6, [&] { return random.uniform(-1e-3, 1e-3); });
    const double moved_mm = (forward_kinematics(scene.robot, q + way).translation() -
                             forward_kinematics(scene.robot, q).translation())
                                .norm();
    EXPECT_LE(moved_mm, checker.largest_change_mm(way) * 1.001);
  }
}

}  // namespace
}  // namespace truepose
