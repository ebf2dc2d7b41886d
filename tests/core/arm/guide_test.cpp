#include "core/arm/guide.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/compensate/target_compensation.hpp"
#include "core/fit/deviation_groups.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/uncertainty.hpp"
#include "core/math/angles.hpp"
#include "tests/allocations.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/plain_kinematics.hpp"
#include "tests/core/pose_differences.hpp"

namespace truepose {
namespace {

/// Random terms of a joint's guide, each of about this size.
void bend(RobotModel& robot, int joint, double shift_mm, double turn_rad, Random& random) {
  for (const GuideMotion& motion : kGuideMotions)
    for (int order = 1; order <= 3; ++order)
      robot.deviation.push_back(
          {joint, motion.basis, order, (motion.turns ? turn_rad : shift_mm) * random.normal()});
}

/// Signs, betas and a flange that do not cancel, with a second slide further out; other deviations too.
RobotModel two_bent_slides(double shift_mm, double turn_rad, Random& random) {
  RobotModel robot = example::oblique_arm_on_a_rail();
  robot.joints[4].type = JointType::Prismatic;
  robot.joints[4].min = -300;
  robot.joints[4].max = 1100;
  robot.deviation = {{0, DeviationBasis::Scale, 1, 0.3}, {2, DeviationBasis::Sine, 2, 1e-3}};
  bend(robot, 0, shift_mm, turn_rad, random);
  bend(robot, 4, shift_mm, turn_rad, random);
  return robot;
}

/// By the text book's matrices alone.
Eigen::Matrix4d flange_by_matrices(const RobotModel& robot, const JointVector& q) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  for (int i = 0; i < robot.joint_count(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    double at = q[i];
    Eigen::Vector3d shift{0, 0, 0}, turn{0, 0, 0};
    for (const DeviationTerm& term : robot.deviation) {
      if (term.joint != i) continue;
      const double wave = term.coefficient * std::cos(term.order * std::acos(-1.0) * (q[i] - joint.min) /
                                                      (joint.max - joint.min));
      switch (term.basis) {
        case DeviationBasis::Scale:
          at += term.coefficient * q[i] / 1000;
          break;
        case DeviationBasis::Sine:
          at += term.coefficient * std::sin(term.order * q[i]);
          break;
        case DeviationBasis::ShiftX:
          shift.x() += wave;
          break;
        case DeviationBasis::ShiftY:
          shift.y() += wave;
          break;
        case DeviationBasis::TurnX:
          turn.x() += wave;
          break;
        case DeviationBasis::TurnY:
          turn.y() += wave;
          break;
        case DeviationBasis::TurnZ:
          turn.z() += wave;
          break;
        default:
          ADD_FAILURE();
      }
    }
    const bool turns = joint.type == JointType::Revolute;
    T = T * plain::turned(1, joint.beta_rad) * plain::turned(0, joint.alpha_rad) *
        plain::shifted({joint.a_mm, 0, 0}) *
        plain::turned(2, joint.theta_rad + (turns ? joint.sign * at : 0)) *
        plain::shifted({0, 0, joint.d_mm + (turns ? 0 : joint.sign * at)});
    T = T * plain::shifted({shift.x(), 0, 0}) * plain::turned(0, turn.x()) *
        plain::shifted({0, shift.y(), 0}) * plain::turned(1, turn.y()) * plain::turned(2, turn.z());
  }
  return T * robot.X_flange.matrix();
}

TEST(Guide, ShiftsAndTurnsAllThatItsCarriageBears) {
  Random random{1};
  const RobotModel robot = two_bent_slides(30, 0.05, random);
  std::vector<Measurement> points;
  for (int k = 0; k < 50; ++k) {
    const JointVector q = example::random_joints(robot, random);
    points.push_back({.q = q});
    const Eigen::Matrix4d expected = flange_by_matrices(robot, q);
    EXPECT_LT((forward_kinematics(robot, q).matrix() - expected).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((forward_with_jacobian(robot, q).X_BF.matrix() - expected).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT((flange_poses(robot, points).back().matrix() - expected).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(Guide, LeavesTheJointsWhereTheirEncodersSay) {
  Random random{2};
  RobotModel robot = example::kr210_on_a_rail();
  bend(robot, 0, 0.2, 1e-4, random);
  const JointVector q = example::random_joints(robot, random);
  EXPECT_EQ(true_joints(robot, q), q);
}

TEST(Guide, MovesPointsAsTheDerivativesToEveryParameterSay) {
  Random random{3};
  for (int trial = 0; trial < 5; ++trial) {
    // Far larger than guides err, so that a turn left out shows.
    CalibratedCell cell = example::placed(two_bent_slides(30, 0.05, random), random, 2);
    const JointVector q = example::random_joints(cell.robot, random);
    PointJacobian J;
    const Eigen::Vector3d point = predict_with_jacobian(cell, q, 1, J);
    EXPECT_LT((point - cell.predict(q, 1)).norm(), 1e-9);
    Eigen::VectorXd f;
    Eigen::MatrixXd by_kernels;
    residuals_with_jacobian(cell, std::vector{Measurement{.q = q, .p_WS_mm = {0, 0, 0}, .smr = 1}}, f,
                            by_kernels);
    EXPECT_LT((point - f).norm(), 1e-9);
    expect_differences(cell, q, 1, J);
    for (Eigen::Index k = 0; k < J.cols(); ++k) {
      EXPECT_LT((by_kernels.col(k) - J.col(k)).norm(), 1e-12 * (1 + J.col(k).norm()))
          << parameter_names(cell)[static_cast<std::size_t>(k)];
    }
  }
}

TEST(Guide, CountsInTheVarianceOfAPosition) {
  Random random{4};
  const CalibratedCell cell = example::placed(two_bent_slides(0.2, 1e-4, random), random);
  const int size = ParameterLayout::of(cell).size();
  const Eigen::MatrixXd root =
      Eigen::MatrixXd::NullaryExpr(size, size, [&] { return 1e-3 * random.normal(); });
  const Eigen::MatrixXd covariance = root * root.transpose();
  std::vector<JointVector> poses;
  for (int k = 0; k < 20; ++k) poses.push_back(example::random_joints(cell.robot, random));
  const Eigen::VectorXd variances = position_variances(cell, covariance, poses);
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const double expected = position_covariance(cell, covariance, poses[k], 0).trace();
    EXPECT_NEAR(variances[static_cast<Eigen::Index>(k)], expected, 1e-10 * expected);
  }
}

TEST(Guide, IsCompensatedExactlyWithoutAllocating) {
  Random random{5};
  const RobotModel nominal = example::kr210_on_a_rail();
  RobotModel real = example::deviating(nominal, random, 0.3, 5e-4);
  real.deviation = {{0, DeviationBasis::Scale, 1, 0.3}};
  bend(real, 0, 0.2, 1e-4, random);
  const TargetCompensation compensation(nominal, real);
  const Eigen::Vector3d p_F_mm{60, -50, 190};
  int reached_count = 0;
  for (int k = 0; k < 200; ++k) {
    const JointVector q = example::random_joints(nominal, random);
    const Eigen::Isometry3d wanted = forward_kinematics(nominal, q);
    const auto before = allocations();
    const auto reached = compensation.at_joints(q, p_F_mm);
    // As the stream does: what is beyond the geometry is looked at where the arm is expected.
    JointVector correction = JointVector::Zero(q.size());
    const NonGeometricError beyond = compensation.non_geometric_error(reached ? reached->q : q);
    const auto streamed = compensation.at_joints_within(100, q, p_F_mm, correction, &beyond);
    EXPECT_EQ(allocations(), before);
    if (!reached) continue;
    ++reached_count;
    const Eigen::Matrix4d stands = flange_by_matrices(real, reached->q);
    EXPECT_LT((plain::moved(stands, p_F_mm) - wanted * p_F_mm).norm(), 1e-6);
    EXPECT_LT(plain::rad_between(stands, wanted.matrix()), reached->damped ? 0.01 : 1e-8);
    ASSERT_TRUE(streamed);
    EXPECT_LT((plain::moved(flange_by_matrices(real, streamed->q), p_F_mm) - wanted * p_F_mm).norm(), 1e-5);
  }
  EXPECT_GT(reached_count, 190);
}

/// What an arm may have that was measured at both ends of every joint's way.
std::vector<DeviationGroup> groups_of(const RobotModel& robot) {
  std::vector<Measurement> points;
  for (const bool up : {false, true}) {
    points.push_back({.q = JointVector(robot.joint_count())});
    for (int i = 0; i < robot.joint_count(); ++i) {
      const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
      points.back().q[i] = up ? joint.max : joint.min;
    }
  }
  return deviation_groups(robot, points, std::vector{1});
}

int terms_of(const std::string& group, const RobotModel& robot) {
  for (const DeviationGroup& each : groups_of(robot))
    if (each.name == group) return static_cast<int>(each.terms.size());
  return 0;
}

TEST(Guide, IsLookedForWhereTheArmWasMeasuredAlongAMetreOrMore) {
  RobotModel rail = example::kr210_on_a_rail();
  EXPECT_EQ(terms_of("joint1.straightness", rail), 2 * 8) << "two half waves for each of 4 m";
  EXPECT_EQ(terms_of("joint1.guide", rail), 3 * 8);
  rail.joints[0].max = rail.joints[0].min + 30'000;
  EXPECT_EQ(terms_of("joint1.straightness", rail), 2 * 20);
  rail.joints[0].max = rail.joints[0].min + 1000;
  EXPECT_EQ(terms_of("joint1.straightness", rail), 2 * 2);
  rail.joints[0].max = rail.joints[0].min + 999;
  EXPECT_EQ(terms_of("joint1.straightness", rail), 0);
  EXPECT_EQ(terms_of("joint3.guide", example::scara()), 0);
  EXPECT_EQ(terms_of("joint1.guide", example::kr210()), 0);
}

TEST(Guide, IsLookedForOfThreeJointsAtMost) {
  RobotModel gantry;
  for (int i = 0; i < 4; ++i)
    gantry.joints.push_back({.type = JointType::Prismatic, .alpha_rad = 1.0 + i, .min = 0, .max = 3000});
  EXPECT_GT(terms_of("joint3.guide", gantry), 0);
  EXPECT_EQ(terms_of("joint4.guide", gantry), 0);
}

TEST(Guide, NamesItsTermsByMotionAndHalfWaves) {
  EXPECT_EQ(deviation_name({0, DeviationBasis::ShiftX, 2}), "joint1.shiftx2");
  EXPECT_EQ(deviation_name({0, DeviationBasis::ShiftY, 1}), "joint1.shifty1");
  EXPECT_EQ(deviation_name({1, DeviationBasis::TurnX, 3}), "joint2.turnx3");
  EXPECT_EQ(deviation_name({1, DeviationBasis::TurnY, 3}), "joint2.turny3");
  EXPECT_EQ(deviation_name({0, DeviationBasis::TurnZ, 1}), "joint1.turnz1");
}

}  // namespace
}  // namespace truepose
