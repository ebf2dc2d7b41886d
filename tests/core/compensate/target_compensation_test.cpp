#include "core/compensate/target_compensation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "core/arm/robot_model.hpp"
#include "core/arm/spherical_wrist.hpp"
#include "core/math/random.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/allocations.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

const RobotModel kNominal = published_arm();
const RobotModel kReal = with_published_errors(kNominal);
const Eigen::Vector3d kTcp_mm{120, -40, 300};

JointVector deg(std::initializer_list<double> q) {
  JointVector result(static_cast<Eigen::Index>(q.size()));
  std::ranges::copy(q, result.begin());
  return result * kRadPerDeg;
}

/// Joints away from the singularities of shoulder and elbow, |A5| at least `least_A5_deg`.
JointVector regular_joints(Random& random, double least_A5_deg) {
  const double A5 = random.uniform(least_A5_deg, 115) * (random.uniform(0, 1) < 0.5 ? -1 : 1);
  return deg({random.uniform(-180, 180), random.uniform(-90, -30), random.uniform(60, 110),
              random.uniform(-300, 300), A5, random.uniform(-300, 300)});
}

/// Arms that deviate by their geometry, by their joints too, and by a field.
RobotModel bending(RobotModel robot) {
  robot.deviation = {{.joint = 1, .basis = DeviationBasis::Weight, .order = 5, .coefficient = 4e-4},
                     {.joint = 2, .basis = DeviationBasis::Sine, .order = 2, .coefficient = 3e-4},
                     {.joint = 4, .basis = DeviationBasis::Cosine, .order = 1, .coefficient = 2e-4}};
  return robot;
}

class WavingField final : public ResidualField {
 public:
  Eigen::Isometry3d displaced(const JointVector& q, const Eigen::Isometry3d& X_BF) const noexcept override {
    Eigen::Isometry3d X = X_BF;
    X.translation() += 0.3 * Eigen::Vector3d(std::sin(q[0]), std::cos(q[1]), std::sin(2 * q[3]));
    X.linear() = Eigen::AngleAxisd(4e-4 * std::sin(q[2]), Eigen::Vector3d::UnitY()) * X.linear();
    return X;
  }
  Eigen::Matrix3d covariance(const JointVector&, const Eigen::Isometry3d&,
                             const Eigen::Vector3d&) const override {
    return Eigen::Matrix3d::Zero();
  }
};

RobotModel with_field(RobotModel robot) {
  robot.field = std::make_shared<WavingField>();
  return robot;
}

double mm_between(const RobotModel& robot, const JointVector& q, const Eigen::Vector3d& p_B_mm,
                  const Eigen::Vector3d& p_F_mm) {
  return (forward_kinematics(robot, q) * p_F_mm - p_B_mm).norm();
}

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
