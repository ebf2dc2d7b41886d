#include "core/compensate/target_compensation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <optional>

#include "tests/allocations.hpp"
#include "tests/core/compensate/compensated_arm.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

TEST(TargetCompensation, AnArmOfFewJointsCorrectsThePositionAlone) {
  Random random(11);
  const RobotModel nominal = example::scara(), real = example::deviating(nominal, random, 0.3, 1e-3);
  const TargetCompensation compensation(nominal, real);
  const JointVector q = example::random_joints(nominal, random);
  const auto refused = compensation.at_joints(q);
  ASSERT_FALSE(refused);
  EXPECT_EQ(
      described(refused.error(), nominal),
      "the calibrated arm cannot reach it: 4 joints cannot correct the six degrees of freedom of a pose; correct "
      "the position alone (--position-only)");
  EXPECT_TRUE(compensation.at_position(forward_kinematics(nominal, q).translation(), q));
}

TEST(TargetCompensation, RegularTargetsAreReachedInPositionAndOrientation) {
  Random random(7);
  for (const RobotModel& real : {kReal, bending(kReal), with_field(bending(kReal))}) {
    const TargetCompensation compensation(kNominal, real);
    for (int i = 0; i < 1000; ++i) {
      const JointVector q = regular_joints(random, 21);
      const Eigen::Isometry3d X = forward_kinematics(kNominal, q);
      const auto reached = compensation.at_joints(q);
      ASSERT_TRUE(reached) << q.transpose() * kDegPerRad;
      EXPECT_FALSE(reached->damped);
      const Eigen::Isometry3d X_real = forward_kinematics(real, reached->q);
      EXPECT_LT((X_real.translation() - X.translation()).norm(), 1e-8);
      EXPECT_LT(angle_between(X_real.linear(), X.linear()), 1e-10);
      EXPECT_LT((reached->q - q).cwiseAbs().maxCoeff(), 5 * kRadPerDeg);
    }
  }
}

TEST(TargetCompensation, NearTheWristSingularityThePositionIsReachedAndTheResidualOrientationIsReported) {
  Random random(11);
  for (const RobotModel& real : {kReal, bending(kReal), with_field(bending(kReal))}) {
    const TargetCompensation compensation(kNominal, real);
    int gives_way = 0;
    for (int i = 0; i < 1000; ++i) {
      JointVector q = regular_joints(random, 0);
      q[4] = random.uniform(-25, 25) * kRadPerDeg;
      const Eigen::Isometry3d X = forward_kinematics(kNominal, q);
      const auto reached = compensation.at_joints(q, kTcp_mm);
      ASSERT_TRUE(reached) << q.transpose() * kDegPerRad;
      EXPECT_NEAR(reached->residual_mm, mm_between(real, reached->q, X * kTcp_mm, kTcp_mm), 1e-8);
      gives_way += reached->residual_mm > 1e-6;
      EXPECT_NEAR(reached->residual_rad,
                  angle_between(forward_kinematics(real, reached->q).linear(), X.linear()), 1e-9);
      EXPECT_LT(reached->residual_rad, 0.025);
    }
    EXPECT_LE(gives_way, 10) << "of 1000 positions";
  }
}

TEST(TargetCompensation, NothingIsCorrectedOnAnArmWithoutErrors) {
  const TargetCompensation compensation(kNominal, kNominal);
  for (const double A5 : {0.0, 1e-9, 0.3, -5.0, 40.0}) {
    const JointVector q = deg({20, -80, 100, 30, A5, -40});
    const auto reached = compensation.at_joints(q);
    ASSERT_TRUE(reached);
    EXPECT_LT((reached->q - q).cwiseAbs().maxCoeff(), 1e-9) << A5;
    EXPECT_LT(reached->residual_rad, 1e-9);
  }
}

/// Arms with every kind of wrist: axes that meet in a point, axes that do not, and axis 4 parallel to axes 2
/// and 3.
std::vector<RobotModel> arms_of_every_wrist() {
  RobotModel offset = kNominal;
  offset.joints[3].a_mm += 40;
  offset.joints[4].a_mm += 85;
  return {kNominal, offset, example::ur10()};
}

/// Points 300 mm from the flange, in its frame.
std::vector<Eigen::Vector3d> points_around_the_flange() {
  Random random(1);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 2000; ++i)
    points.push_back(300 * Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized());
  return points;
}

double worst_mm(const std::vector<Eigen::Vector3d>& points, const Eigen::Isometry3d& X,
                const Eigen::Isometry3d& wanted) {
  double worst = 0;
  for (const Eigen::Vector3d& p : points) worst = std::max(worst, (X * p - wanted * p).norm());
  return worst;
}

TEST(TargetCompensation, LeavesNoPointNearTheFlangeWorseThanNoCorrectionWhateverTheWrist) {
  Random random(23);
  const auto points = points_around_the_flange();
  for (const RobotModel& nominal : arms_of_every_wrist()) {
    int damped = 0, position_gives_way = 0;
    for (int i = 0; i < 3000; ++i) {
      const RobotModel real = example::deviating(nominal, random, 0.5, 0.004 * random.uniform(0, 1));
      const TargetCompensation compensation(nominal, real);
      const JointVector q = example::random_joints(nominal, random);
      const Eigen::Vector3d p_F_mm =
          random.uniform(0, 1) * points[static_cast<std::size_t>(random.uniform(0, 2000))];
      const auto reached = compensation.at_joints(q, p_F_mm);
      if (!reached || !reached->damped) continue;
      ++damped;
      const Eigen::Isometry3d wanted = forward_kinematics(nominal, q);
      const Eigen::Isometry3d without = forward_kinematics(real, q);
      const Eigen::Isometry3d with = forward_kinematics(real, reached->q);
      ASSERT_LE(angle_between(with.linear(), wanted.linear()),
                angle_between(without.linear(), wanted.linear()) + 1e-8)
          << q.transpose();
      // The points are not all points: a percent for those between.
      ASSERT_LE(worst_mm(points, with, wanted), 1.01 * worst_mm(points, without, wanted) + 1e-6)
          << q.transpose();
      ASSERT_NEAR(reached->residual_mm, (with * p_F_mm - wanted * p_F_mm).norm(), 1e-8);
      ASSERT_NEAR(reached->residual_rad, angle_between(with.linear(), wanted.linear()), 1e-9);
      position_gives_way += reached->residual_mm > 1e-6;
    }
    std::cout << nominal.name << ": of 3000 targets " << damped << " are damped, the position of "
              << position_gives_way << " gives way\n";
    EXPECT_GT(damped, 300);
    EXPECT_GT(position_gives_way, 0);
    EXPECT_LT(position_gives_way, damped / 3);
  }
}

TEST(TargetCompensation, WhereThePositionGivesWayNeighboursStayNeighbours) {
  constexpr int kLines = 1000, kSteps = 200;
  constexpr double kStep_rad = 5e-4;
  Random random(29);
  const TargetCompensation compensation(kNominal, kReal);
  int gives_way = 0;
  double jump = 0;  // largest change of the correction over the way in between
  for (int line = 0; line < kLines; ++line) {
    JointVector q = regular_joints(random, 0);
    q[4] = random.uniform(-20, 20) * kRadPerDeg;
    JointVector step(6);
    for (double& each : step) each = random.normal();
    step *= kStep_rad / step.norm();
    std::optional<CompensatedTarget> before;
    JointVector correction_before;
    for (int i = 0; i < kSteps; ++i, q += step) {
      const auto reached = compensation.at_joints(q, kTcp_mm);
      if (!reached) break;
      const JointVector correction = reached->q - q;
      gives_way += reached->residual_mm > 1e-6;
      if (before && std::max(before->residual_mm, reached->residual_mm) > 1e-6)
        jump = std::max(jump, (correction - correction_before).norm() / kStep_rad);
      before = *reached;
      correction_before = correction;
    }
  }
  std::cout << "seed 29: the position of " << gives_way << " of " << kLines * kSteps
            << " targets gives way, largest jump " << jump << " of the way\n";
  EXPECT_GT(gives_way, 100);
  EXPECT_LT(jump, 0.1);
}

TEST(TargetCompensation, ATargetBeyondAJointLimitIsRefusedByItsJoint) {
  const TargetCompensation compensation(kNominal, kReal);
  const auto above = compensation.at_joints(deg({0, -90, 90, 0, 30, 349.99}));
  const auto below = compensation.at_joints(deg({0, -90, 90, 0, 30, -349.99}));
  ASSERT_NE(above.has_value(), below.has_value());
  const CompensationFault fault = above ? below.error() : above.error();
  EXPECT_EQ(fault.kind, CompensationFault::Kind::BeyondLimit);
  EXPECT_EQ(fault.joint, 5);
  EXPECT_GT(std::abs(fault.q_wrong), 350 * kRadPerDeg);
}

TEST(TargetCompensation, JointsThatAreNoNumbersAreRefused) {
  const TargetCompensation compensation(kNominal, kReal);
  for (const double A5 : {0.1, double{NAN}, double{INFINITY}}) {
    JointVector q = deg({0, -90, 90, 0, A5, 0});
    if (std::isfinite(A5)) q[1] = NAN;
    ASSERT_FALSE(compensation.at_joints(q));
    ASSERT_FALSE(compensation.at_position(Eigen::Vector3d(1500, 0, 1500), q));
  }
}

// Position alone.

TEST(TargetCompensation, APositionAloneIsReachedByTheSmallestChangeOfTheJoints) {
  Random random(3);
  for (const RobotModel& real : {kReal, bending(kReal)}) {
    const TargetCompensation compensation(kNominal, real);
    for (int i = 0; i < 200; ++i) {
      const JointVector q = regular_joints(random, 0);
      const Eigen::Vector3d p_B_mm = forward_kinematics(kNominal, q) * kTcp_mm;
      const auto reached = compensation.at_position(p_B_mm, q, kTcp_mm);
      ASSERT_TRUE(reached);
      EXPECT_LT(mm_between(real, reached->q, p_B_mm, kTcp_mm), 1e-8);
      // Any other way to the same position is longer: joints moved at random and brought back to it.
      for (int k = 0; k < 10; ++k) {
        JointVector aside = reached->q;
        for (double& value : aside) value += 2e-3 * random.normal();
        const auto other = compensation.at_position(p_B_mm, aside, kTcp_mm);
        ASSERT_TRUE(other);
        EXPECT_GE((other->q - q).norm(), (reached->q - q).norm() - 1e-7);
      }
    }
  }
}

TEST(TargetCompensation, APositionFarAwayIsReached) {
  const TargetCompensation compensation(kNominal, kReal);
  const Eigen::Vector3d p_B_mm(1200, -900, 1700);
  const auto reached = compensation.at_position(p_B_mm, deg({30, -80, 100, 0, 40, 0}));
  ASSERT_TRUE(reached);
  EXPECT_LT(mm_between(kReal, reached->q, p_B_mm, Eigen::Vector3d::Zero()), 1e-8);
}

TEST(TargetCompensation, AJointThatWouldGoBeyondItsLimitStaysAtItWhereThePositionAllows) {
  RobotModel nominal = kNominal;
  const JointVector q = deg({10, -80, 100, 20, 40, -30});
  const Eigen::Vector3d p_B_mm = forward_kinematics(nominal, q) * kTcp_mm;
  const auto free = TargetCompensation(nominal, kReal).at_position(p_B_mm, q, kTcp_mm);
  ASSERT_TRUE(free);
  ASSERT_LT(free->q[0], q[0] + 0.1);
  const bool upwards = free->q[0] > q[0];
  (upwards ? nominal.joints[0].max : nominal.joints[0].min) = q[0];
  const auto limited = TargetCompensation(nominal, kReal).at_position(p_B_mm, q, kTcp_mm);
  ASSERT_TRUE(limited);
  EXPECT_DOUBLE_EQ(limited->q[0], q[0]);
  EXPECT_LT(mm_between(kReal, limited->q, p_B_mm, kTcp_mm), 1e-8);
}

TEST(TargetCompensation, APositionOutOfReachIsRefused) {
  const TargetCompensation compensation(kNominal, kReal);
  EXPECT_FALSE(compensation.at_position({9000, 0, 1000}, deg({0, -90, 90, 0, 30, 0})));
}

TEST(TargetCompensation, ArmsWithMoreJointsAreCompensatedToo) {
  Random random(9);
  for (const RobotModel& nominal : {example::kr210_on_a_rail(), example::seven_axis()}) {
    const RobotModel real = example::deviating(nominal, random, 0.3, 0.0005);
    const TargetCompensation compensation(nominal, real);
    int reached_count = 0;
    for (int i = 0; i < 200; ++i) {
      const JointVector q = example::random_joints(nominal, random);
      const auto reached = compensation.at_joints(q);
      if (!reached) continue;
      ++reached_count;
      EXPECT_LT(
          mm_between(real, reached->q, forward_kinematics(nominal, q).translation(), Eigen::Vector3d::Zero()),
          1e-8);
      EXPECT_LT(reached->residual_rad, reached->damped ? 0.01 : 1e-10);
    }
    EXPECT_GT(reached_count, 190);
  }
}

TEST(TargetCompensation, OfATargetThatMovesIsFoundInFewStepsFromTheOneBefore) {
  constexpr int kSteps = 8;
  struct Way {
    JointVector from, to;
  };
  const Way regular{deg({20, -80, 100, 30, 60, -40}), deg({-60, -50, 70, -80, 30, 60})},
      through_the_wrist{deg({20, -80, 100, 30, 10, -40}), deg({20, -80, 100, 30, -10, -40})},
      towards_the_end_of_reach{deg({20, -60, 40, 30, 45, -40}), deg({20, -60, 8, 30, 45, -40})};
  for (const RobotModel& real : {kReal, bending(kReal), with_field(bending(kReal))}) {
    const TargetCompensation compensation(kNominal, real);
    for (const Way& way : {regular, through_the_wrist, towards_the_end_of_reach}) {
      JointVector correction = JointVector::Zero(6);
      for (int i = 0; i <= 1000; ++i) {
        const JointVector q = way.from + (way.to - way.from) * (i / 1000.0);
        const auto found = compensation.at_joints_within(kSteps, q, kTcp_mm, correction);
        const auto expected = compensation.at_joints(q, kTcp_mm);
        ASSERT_TRUE(found && expected) << q.transpose() * kDegPerRad;
        ASSERT_LE(found->iterations, kSteps);
        ASSERT_LT((found->q - expected->q).cwiseAbs().maxCoeff(), 1e-9) << q.transpose() * kDegPerRad;
        ASSERT_EQ(correction, found->q - q);
      }
    }
  }
}

TEST(TargetCompensation, ThatStepsWereTooFewForIsFoundByTheNextOnes) {
  for (const RobotModel& real : {kReal, bending(kReal), with_field(bending(kReal))}) {
    const TargetCompensation compensation(kNominal, real);
    for (const double a5_deg : {60.0, 5.0, 0.0}) {
      const JointVector q = deg({20, -80, 100, 30, a5_deg, -40});
      JointVector correction = JointVector::Zero(6);
      int calls = 1;
      auto found = compensation.at_joints_within(2, q, kTcp_mm, correction);
      EXPECT_EQ(found.error().kind, CompensationFault::Kind::DidNotConverge);
      for (; !found && calls < 20; ++calls) found = compensation.at_joints_within(2, q, kTcp_mm, correction);
      ASSERT_TRUE(found) << a5_deg;
      EXPECT_LT((found->q - compensation.at_joints(q, kTcp_mm)->q).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(TargetCompensation, RestartsWhereASearchLedNowhere) {
  RobotModel longer = kNominal;
  longer.joints[2].a_mm += 15;
  const TargetCompensation compensation(kNominal, longer);
  JointVector correction = JointVector::Zero(6);
  int led_nowhere = 0;
  for (double a3_deg = 0; a3_deg < 10; a3_deg += 0.01) {
    const JointVector q = deg({20, -60, a3_deg, 30, 45, -40});
    const auto found = compensation.at_joints_within(50, q, kTcp_mm, correction);
    if (found || found.error().kind != CompensationFault::Kind::TooFar) continue;
    ++led_nowhere;
    EXPECT_TRUE(correction.isZero(0)) << correction.transpose();
  }
  EXPECT_GT(led_nowhere, 10);
  EXPECT_FALSE(compensation.at_joints_within(8, JointVector::Constant(6, NAN), kTcp_mm, correction));
  EXPECT_TRUE(correction.isZero(0));
}

TEST(TargetCompensation, DoesNotAllocate) {
  const TargetCompensation compensation(kNominal, bending(kReal));
  const JointVector regular = deg({20, -80, 100, 30, 40, -40}), singular = deg({20, -80, 100, 30, 1, -40});
  const auto before = allocations();
  if (!before) GTEST_SKIP() << "a sanitizer has taken malloc for itself";
  const bool done = compensation.at_joints(regular) && compensation.at_joints(singular) &&
                    compensation.at_position({1500, 200, 1500}, regular);
  EXPECT_EQ(allocations(), before);
  EXPECT_TRUE(done);
}

}  // namespace
}  // namespace truepose
