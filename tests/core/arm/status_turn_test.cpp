#include "core/arm/status_turn.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/tools/kuka_controller_oracle.hpp"

namespace truepose {
namespace {

const RobotModel kArm = published_arm();

StatusTurnInverse the_inverse() { return StatusTurnInverse::of(kArm).value(); }

JointVector joints_deg(std::initializer_list<double> deg) {
  JointVector q(6);
  std::ranges::copy(deg, q.begin());
  return q * kRadPerDeg;
}

JointVector within_the_limits(Random& random) {
  JointVector q(6);
  for (std::size_t i = 0; i < 6; ++i)
    q[static_cast<Eigen::Index>(i)] = random.uniform(kArm.joints[i].min, kArm.joints[i].max);
  return q;
}

TEST(StatusTurn, OfTheUprightArmIsTheKnownOne) {
  const StatusTurn home = the_inverse().of_joints(joints_deg({0, -90, 90, 0, 90, 0}));
  EXPECT_EQ(home.status, 0b010);
  EXPECT_EQ(home.turn, 0b000010);
  const StatusTurn other = the_inverse().of_joints(joints_deg({20, -70, 60, 15, -40, 100}));
  EXPECT_EQ(other.status, 0b110);
  EXPECT_EQ(other.turn, 0b010010);
}

TEST(StatusTurn, IsAsTheDrawingOfTheArmHasItAtRandomJoints) {
  const StatusTurnInverse inverse = the_inverse();
  Random random(11);
  std::array<int, 8> seen{};
  for (int i = 0; i < 20'000; ++i) {
    const JointVector q = within_the_limits(random);
    const StatusTurn found = inverse.of_joints(q);
    ASSERT_EQ(found.status, oracle::status(q)) << q.transpose() * kDegPerRad;
    ASSERT_EQ(found.turn, oracle::turn(q)) << q.transpose() * kDegPerRad;
    ++seen[static_cast<std::size_t>(found.status)];
  }
  for (const int count : seen) EXPECT_GT(count, 100);
}

TEST(StatusTurn, LeadBackToTheJointsTheyCameFrom) {
  const StatusTurnInverse inverse = the_inverse();
  Random random(12);
  for (int i = 0; i < 20'000; ++i) {
    const JointVector q = within_the_limits(random);
    if (std::abs(std::sin(q[4])) < 1e-3) continue;
    const Eigen::Isometry3d X = forward_kinematics(kArm, q);
    const auto found = inverse.solve(X, oracle::status(q), oracle::turn(q), {});
    ASSERT_TRUE(found) << found.error() << " " << q.transpose() * kDegPerRad;
    ASSERT_LT((*found - q).cwiseAbs().maxCoeff(), 1e-6) << q.transpose() * kDegPerRad;
  }
}

TEST(StatusTurn, CountOnBothSidesWhereAnAxisStandsOnItsBoundary) {
  const StatusTurnInverse inverse = the_inverse();
  const JointVector q = joints_deg({0, -90, 90, 0, 45, 0});
  for (const int turn : {0b000010, 0b101011, 0b001010}) {
    const auto found = inverse.solve(forward_kinematics(kArm, q), 0b010, turn, {});
    ASSERT_TRUE(found) << turn;
    EXPECT_LT((*found - q).cwiseAbs().maxCoeff(), 1e-9) << turn;
    EXPECT_EQ(inverse.of_joints(*found, StatusTurn{0b010, turn}).turn, turn);
  }
  // In the wrist singularity only the sum of A4 and A6 is determined; A4 becomes 0.
  const auto singular =
      inverse.solve(forward_kinematics(kArm, joints_deg({0, -90, 90, 20, 0, 10})), 0b110, 0b10, {});
  ASSERT_TRUE(singular);
  EXPECT_LT((*singular - joints_deg({0, -90, 90, 0, 0, 30})).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(StatusTurn, MissingOnesAreThoseNearestToWhereTheArmComesFrom) {
  const StatusTurnInverse inverse = the_inverse();
  const JointVector q = joints_deg({30, -80, 100, -170, -40, 200});
  const Eigen::Isometry3d X = forward_kinematics(kArm, q);
  const JointVector near = q + JointVector::Constant(6, 0.1);
  for (const auto& [status, turn] : {std::pair<std::optional<int>, std::optional<int>>{{}, {}},
                                     {oracle::status(q), {}},
                                     {{}, oracle::turn(q)}}) {
    EXPECT_LT((inverse.solve(X, status, turn, near).value() - q).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_FALSE(inverse.solve(X, status, turn, {}));
  }
}

TEST(StatusTurn, WhatCannotBeReachedIsSaid) {
  const StatusTurnInverse inverse = the_inverse();
  Eigen::Isometry3d far = Eigen::Isometry3d::Identity();
  far.translation().x() = 9000;
  EXPECT_EQ(inverse.solve(far, 2, 2, {}).error(), "the position is out of the arm's reach");
  const Eigen::Isometry3d X = forward_kinematics(kArm, joints_deg({0, -90, 90, 0, 45, 0}));
  EXPECT_EQ(inverse.solve(X, 0b010, 0b000000, {}).error(),
            "the arm cannot take the position with S 2 and T 0 within its joint limits");
  for (const double nasty : {1e300, std::numeric_limits<double>::infinity(), std::nan("")}) {
    far.translation().x() = nasty;
    EXPECT_FALSE(inverse.solve(far, 2, 2, {}));
  }
}

/// The wrist of a KR 210 whose axis 5 is 80 mm off axes 4 and 6, as in arms without a spherical wrist.
RobotModel arm_with_an_offset_wrist() {
  RobotModel arm = kArm;
  arm.joints[4].a_mm += 80;
  arm.joints[5].a_mm += 30;
  return arm;
}

TEST(SearchedInverse, FindsTheJointsThatTurnAndTheirNeighbourhoodMean) {
  const RobotModel arm = arm_with_an_offset_wrist();
  EXPECT_FALSE(StatusTurnInverse::of(arm));
  const StatusTurnInverse inverse = StatusTurnInverse::by_search(arm).value();
  EXPECT_TRUE(inverse.searches());
  Random random(31);
  for (int i = 0; i < 200; ++i) {
    const JointVector q = within_the_limits(random), near = q + JointVector::Constant(6, 0.05);
    const Eigen::Isometry3d X = forward_kinematics(arm, q);
    const auto solved = inverse.solve(X, 0b010, oracle::turn(q), near);
    ASSERT_TRUE(solved) << solved.error() << " at " << q.transpose();
    EXPECT_LT((forward_kinematics(arm, *solved).translation() - X.translation()).norm(), 1e-6);
    EXPECT_EQ(oracle::turn(*solved), oracle::turn(q));
    EXPECT_LT((*solved - near).norm(), (q - near).norm() + 1e-6) << "of several with one turn the nearest";
  }
}

TEST(SearchedInverse, IsTheClosedFormWhereThereIsOneAndNeedsSixAxes) {
  EXPECT_FALSE(StatusTurnInverse::by_search(kArm).value().searches());
  RobotModel five = kArm;
  five.joints.pop_back();
  EXPECT_FALSE(StatusTurnInverse::by_search(five));
}

}  // namespace
}  // namespace truepose
