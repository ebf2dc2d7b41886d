// Targets at and near the singularities of wrist, axis 1 and reach.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/arm/spherical_wrist.hpp"
#include "core/compensate/target_compensation.hpp"
#include "tests/core/compensate/compensated_arm.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

/// How the corrections behave along nominal joint positions.
struct Line {
  JointVector largest = JointVector::Zero(6);  // |correction| of each joint, rad
  double jump = 0;                             // largest change of one over the nominal way in between
  double mm = 0, rad = 0;
};

Line along(const TargetCompensation& compensation, const std::vector<JointVector>& joints) {
  Line line;
  JointVector last;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const auto reached = compensation.at_joints(joints[i]);
    if (!reached) {
      ADD_FAILURE() << "target " << i;
      return line;
    }
    const JointVector correction = reached->q - joints[i];
    line.largest = line.largest.cwiseMax(correction.cwiseAbs());
    if (i > 0)
      line.jump = std::max(line.jump, (correction - last).norm() / (joints[i] - joints[i - 1]).norm());
    last = correction;
    line.mm =
        std::max(line.mm, mm_between(kReal, reached->q, forward_kinematics(kNominal, joints[i]).translation(),
                                     Eigen::Vector3d::Zero()));
    line.rad = std::max(line.rad, reached->residual_rad);
  }
  return line;
}

std::vector<JointVector> through_axis_5(double from_deg, double to_deg, int points) {
  std::vector<JointVector> joints;
  for (int i = 0; i < points; ++i)
    joints.push_back(deg({20, -80, 100, 30, from_deg + (to_deg - from_deg) * i / (points - 1), -40}));
  return joints;
}

/// A straight line of the flange, its orientation constant, that passes the singularity at a small distance.
std::vector<JointVector> past_the_singularity(int points) {
  const auto inverse = SphericalWristInverse::of(kNominal);
  const Eigen::Isometry3d X_middle = forward_kinematics(kNominal, deg({20, -80, 100, 30, 0.3, -40}));
  std::vector<JointVector> joints;
  JointVector near = deg({20, -80, 100, 30, 0.3, -40});
  for (int i = 0; i < points; ++i) {
    Eigen::Isometry3d X = X_middle;
    const double part = 2.0 * i / (points - 1) - 1;
    X.translation() += part * Eigen::Vector3d(0, 250, 44);
    near = *inverse->nearest(X, near);
    joints.push_back(near);
  }
  return joints;
}

constexpr double kBound = 0.5 * kRadPerDeg;

TEST(TargetCompensation, ALineThroughTheSingularityNeedsNoLargeCorrectionAndHasNoJump) {
  const TargetCompensation compensation(kNominal, kReal);
  const Line line = along(compensation, through_axis_5(-10, 10, 801));
  EXPECT_LT(line.largest.maxCoeff(), kBound) << line.largest.transpose() * kDegPerRad;
  EXPECT_LT(line.jump, 0.1);
  EXPECT_LT(line.mm, 1e-6);
  EXPECT_LT(line.rad, 0.015);
  // Without the bound the same line needs a hundred degrees, where it can be solved at all.
  const TargetCompensation unbounded(kNominal, kReal, {.singular_below = 0, .approach = {}});
  const auto exact = unbounded.at_joints(deg({20, -80, 100, 30, 2, -40}));
  ASSERT_FALSE(exact);
  EXPECT_EQ(exact.error().kind, CompensationFault::Kind::TooFar);
  EXPECT_GT(std::abs(exact.error().too_large), 10 * kRadPerDeg);
}

/// Corrections of targets on both sides of a singularity, and how many of them were refused.
struct Crossing {
  double largest = 0;
  int refused = 0, too_far = 0;
};

Crossing across(const TargetCompensation& compensation, JointVector q, Eigen::Index axis, double from_deg,
                double to_deg) {
  constexpr int kPoints = 1001;
  Crossing crossing;
  for (int i = 0; i < kPoints; ++i) {
    q[axis] = (from_deg + (to_deg - from_deg) * i / (kPoints - 1)) * kRadPerDeg;
    const auto reached = compensation.at_joints(q);
    if (reached) {
      crossing.largest = std::max(crossing.largest, (reached->q - q).cwiseAbs().maxCoeff());
      EXPECT_LT(reached->residual_mm, 1e-8);
      continue;
    }
    ++crossing.refused;
    crossing.too_far += reached.error().kind == CompensationFault::Kind::TooFar;
  }
  return crossing;
}

TEST(TargetCompensation, WhereTheWristIsNearAxis1ATargetIsRefusedRatherThanCorrectedFar) {
  const Crossing crossing =
      across(TargetCompensation(kNominal, kReal), deg({20, -130, 0, 30, 45, -40}), 2, 60, 70);
  EXPECT_LE(crossing.largest, 10 * kRadPerDeg);
  EXPECT_GT(crossing.largest, 5 * kRadPerDeg);
  EXPECT_GT(crossing.too_far, 10);
  EXPECT_LT(crossing.refused, 200) << "2 deg of 10";
}

TEST(TargetCompensation, NearTheEndOfTheReachATargetIsRefusedRatherThanCorrectedFar) {
  const JointVector stretched_near = deg({20, -60, 0, 30, 45, -40});
  RobotModel longer = kNominal, shorter = kNominal;
  longer.joints[2].a_mm += 15;
  shorter.joints[2].a_mm -= 15;
  const Crossing of_longer = across(TargetCompensation(kNominal, longer), stretched_near, 2, 0, 10);
  EXPECT_LE(of_longer.largest, 10 * kRadPerDeg);
  EXPECT_GT(of_longer.too_far, 10);
  const Crossing of_shorter = across(TargetCompensation(kNominal, shorter), stretched_near, 2, 0, 10);
  EXPECT_LE(of_shorter.largest, 10 * kRadPerDeg);
  EXPECT_GT(of_shorter.refused, 100) << "out of its reach";
}

TEST(TargetCompensation, TheRefusalNamesTheJointAndWhatToDo) {
  const auto refused = TargetCompensation(kNominal, kReal).at_joints(deg({20, -130, 64.8, 30, 45, -40}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(described(refused.error(), kNominal),
            "joint 4 would have to be corrected by -18.0 deg: too near to a singularity; move it away from "
            "there");
}

TEST(TargetCompensation, ALineOnWhichAxis4HasToTurnRoundNeedsNoLargeCorrectionAndHasNoJump) {
  const std::vector<JointVector> joints = past_the_singularity(801);
  double largest_turn = 0, least_A5 = 1;
  for (const JointVector& q : joints) {
    largest_turn = std::max(largest_turn, std::abs(q[3] - joints.front()[3]));
    least_A5 = std::min(least_A5, std::abs(q[4]));
  }
  ASSERT_GT(largest_turn, 90 * kRadPerDeg);
  ASSERT_LT(least_A5, 0.5 * kRadPerDeg);
  const TargetCompensation compensation(kNominal, kReal);
  const Line line = along(compensation, joints);
  // Axis 5 has its own error, which has nothing to do with the singularity.
  EXPECT_LT(std::max(line.largest[3], line.largest[5]), kBound) << line.largest.transpose() * kDegPerRad;
  EXPECT_LT(line.largest.maxCoeff(), 0.6 * kRadPerDeg) << line.largest.transpose() * kDegPerRad;
  EXPECT_LT(line.jump, 0.1);
  EXPECT_LT(line.mm, 1e-6);
  EXPECT_LT(line.rad, 0.015);
}

TEST(TargetCompensation, OutsideTheDampedZoneNeighboursStayNeighbours) {
  const TargetCompensation compensation(kNominal, kReal);
  // The zone ends near 20 deg: exact beyond, bounded within, no step between.
  const Line line = along(compensation, through_axis_5(15, 25, 2001));
  EXPECT_LT(line.jump, 2);
  const Line finer = along(compensation, through_axis_5(19, 21, 4001));
  EXPECT_LT(finer.jump, 2);
}

TEST(TargetCompensation, SmallErrorsOfOrientationAreCorrectedWhereTheBoundAllows) {
  RobotModel real = kNominal;
  real.joints[3].alpha_rad += 0.0005;  // of a good arm
  const TargetCompensation compensation(kNominal, real);
  for (const double A5 : {12.0, -12.0}) {
    const auto reached = compensation.at_joints(deg({20, -80, 100, 30, A5, -40}));
    ASSERT_TRUE(reached);
    EXPECT_FALSE(reached->damped);
    EXPECT_LT(reached->residual_rad, 1e-11);
  }
}

/// Axes 4 and 6 never leave the bound by more than the correction that regular neighbours need, whatever the
/// errors: of seeded arms and targets, the correction where the angle between the axes is at the threshold.
TEST(TargetCompensation, NoCorrectionOfTheWristExceedsTheBoundByMoreThanNeighboursNeed) {
  Random random(5);
  for (int arm = 0; arm < 40; ++arm) {
    const RobotModel real = example::deviating(kNominal, random, 0.5, 0.004 * random.uniform(0, 1));
    const TargetCompensation compensation(kNominal, real);
    for (int i = 0; i < 25; ++i) {
      JointVector q = regular_joints(random, 0);
      double neighbours = 0;
      for (const double A5 : {-22.0, 22.0}) {
        q[4] = A5 * kRadPerDeg;
        const auto reached = compensation.at_joints(q);
        ASSERT_TRUE(reached);
        neighbours = std::max(neighbours, (reached->q - q).cwiseAbs().maxCoeff());
      }
      for (const double A5 : {-0.01, 0.0, 0.4, 1.0, -2.0, 4.0, -7.0, 11.0, 17.0}) {
        q[4] = A5 * kRadPerDeg;
        const auto reached = compensation.at_joints(q);
        ASSERT_TRUE(reached) << q.transpose() * kDegPerRad;
        EXPECT_LT((reached->q - q).cwiseAbs().maxCoeff(), 1.25 * neighbours + kBound) << A5;
      }
    }
  }
}

}  // namespace
}  // namespace truepose
