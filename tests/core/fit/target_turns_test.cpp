#include "core/fit/target_turns.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <iostream>

#include "core/arm/forward.hpp"
#include "core/calibrate/calibrate.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/frames/tool_turn.hpp"
#include "core/math/angles.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"

namespace truepose {
namespace {

constexpr std::uint64_t kSeed = 20261128;
constexpr double kTurn_rad = 1e-4;
constexpr double kStep = 1e-6;

Eigen::Vector3d normal_vector(Random& random) {
  Eigen::Vector3d v;
  for (double& axis : v) axis = random.normal();
  return v;
}

/// An arm on a rail whose every joint errs with its angle, and whose carriage rolls: all kinds of parameters.
CalibratedCell cell_with_deviations(Random& random) {
  CalibratedCell cell = example::placed(example::oblique_arm_on_a_rail(), random, 2);
  for (int joint = 1; joint < cell.robot.joint_count(); ++joint)
    cell.robot.deviation.push_back({joint, DeviationBasis::Sine, 2, 1e-4 * random.normal()});
  for (const DeviationBasis basis : {DeviationBasis::ShiftY, DeviationBasis::TurnX, DeviationBasis::TurnZ})
    cell.robot.deviation.push_back(
        {0, basis, 1, (basis == DeviationBasis::ShiftY ? 0.1 : 1e-4) * random.normal()});
  return cell;
}

/// 6-D readings of both targets, their mountings far from the flange's axes and some turned off by a little.
std::vector<Measurement> readings(const CalibratedCell& cell, int poses, Random& random) {
  const std::array mounted{rotation_by({0.5, -1.2, 0.3}), rotation_by({-2, 0.4, 1})};
  std::vector<Measurement> points;
  for (int n = 0; n < poses; ++n) {
    Measurement point{.q = example::random_joints(cell.robot, random), .smr = n % 2};
    const Eigen::Matrix3d R_WF =
        cell.base.isometry().linear() * forward_kinematics(cell.robot, point.q).linear();
    point.p_WS_mm = cell.predict(point.q, point.smr);
    point.orientation = {
        rotation_by(2e-4 * normal_vector(random)) * R_WF * mounted[static_cast<std::size_t>(point.smr)],
        kTurn_rad * random.uniform(0.5, 2)};
    points.push_back(point);
  }
  return points;
}

Eigen::MatrixXd differences(const CalibratedCell& cell, int size,
                            const std::function<Eigen::VectorXd(const CalibratedCell&)>& of) {
  Eigen::MatrixXd slopes(of(cell).size(), size);
  for (int k = 0; k < size; ++k) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(size, k);
    slopes.col(k) = (of(moved(cell, step)) - of(moved(cell, -step))) / (2 * kStep);
  }
  return slopes;
}

TEST(TurnWithJacobian, IsWhatCentralDifferencesOfTheFlangesTurnComeTo) {
  std::cout << "seed " << kSeed << "\n";
  Random random{kSeed};
  for (int trial = 0; trial < 5; ++trial) {
    const CalibratedCell cell = cell_with_deviations(random);
    const JointVector q = example::random_joints(cell.robot, random);
    PointJacobian J;
    const Eigen::Matrix3d R_WF = turn_with_jacobian(cell, q, J);
    EXPECT_LT(angle_between(R_WF, cell.base.isometry().linear() * forward_kinematics(cell.robot, q).linear()),
              1e-12);
    const Eigen::MatrixXd slopes =
        differences(cell, static_cast<int>(J.cols()), [&](const CalibratedCell& at) {
          return turn_between(R_WF, at.base.isometry().linear() * forward_kinematics(at.robot, q).linear());
        });
    EXPECT_LT((J - slopes).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(RowsOfTurns, AreWhatTheirOwnDifferencesComeTo) {
  std::cout << "seed " << kSeed << "\n";
  Random random{kSeed};
  const CalibratedCell cell = cell_with_deviations(random);
  const std::vector<Measurement> points = readings(cell, 9, random);
  const int size = ParameterLayout::of(cell).size();
  LeastSquaresProblem problem{.points = points, .free = first_parameters(size), .W = {}, .prior = {}};
  problem.turn_weight = turn_weights(points, 0.01);
  const LinearSystem system = linearise(cell, problem);
  ASSERT_EQ(system.f.size(), 6 * 9);
  EXPECT_EQ(system.mountings, 6);
  const Eigen::MatrixXd slopes = differences(cell, size, [&](const CalibratedCell& at) {
    return Eigen::VectorXd{linearise(at, problem).f.tail(27)};
  });
  // Turns of 1e-4 rad: their product with the mounting that follows the parameters is what is left out.
  EXPECT_LT((system.J.bottomRows(27) - slopes).cwiseAbs().maxCoeff(), 1e-3 * slopes.cwiseAbs().maxCoeff());
  const Eigen::VectorXd gradient = system.J.transpose() * system.f;
  for (int k = 0; k < size; ++k) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(size, k);
    const double slope = (linearise(moved(cell, step), problem).f.squaredNorm() -
                          linearise(moved(cell, -step), problem).f.squaredNorm()) /
                         (4 * kStep);
    EXPECT_NEAR(gradient[k], slope, 1e-4 * gradient.norm()) << k;
  }
}

TEST(ToolTurn, FollowsTheModelAsItsDifferencesHaveIt) {
  std::cout << "seed " << kSeed << "\n";
  Random random{kSeed};
  const CalibratedCell cell = cell_with_deviations(random);
  FrameReadings data{.points = {{kOrigin, {}}}};
  for (const Measurement& point : readings(cell, 10, random))
    if (point.smr == 0) data.readings.push_back({.q = point.q, .orientation = point.orientation});
  const auto here = tool_turn(data, {.cell = cell});
  ASSERT_TRUE(here) << here.error();
  const int size = ParameterLayout::of(cell).size();
  ASSERT_EQ(here->by_parameters.cols(), size);
  const Eigen::MatrixXd slopes = differences(cell, size, [&](const CalibratedCell& at) {
    return Eigen::VectorXd{turn_between(here->R_FT, tool_turn(data, {.cell = at})->R_FT)};
  });
  // The readings turn by 2e-4 rad: by so much of itself is the mean of turns none of vectors.
  EXPECT_LT((here->by_parameters - slopes).cwiseAbs().maxCoeff(), 1e-3 * slopes.cwiseAbs().maxCoeff());
}

TEST(RowsOfTurns, SayNothingOfAJointThatTurnsTheTargetAlone) {
  // Joint 6 and the mounting behind it: whatever the turns, none shows which of them it was.
  Random random{kSeed};
  const CalibratedCell cell = cell_with_deviations(random);
  std::vector<Measurement> points = readings(cell, 9, random);
  for (Measurement& point : points)
    point.orientation->R_WT = rotation_by(0.01 * normal_vector(random)) * point.orientation->R_WT;
  const ParameterLayout layout = ParameterLayout::of(cell);
  LeastSquaresProblem problem{
      .points = points, .free = {layout.link(6) + ParameterLayout::kTheta}, .W = {}, .prior = {}};
  problem.turn_weight = turn_weights(points, 0.01);
  EXPECT_LT(linearise(cell, problem).J.bottomRows(27).norm(), 1e-9);
}

TEST(RowsOfTurns, AreThoseOfAFitWithTheMountingFree) {
  // The oracle has the mountings as parameters of its own, and eliminates them.
  std::cout << "seed " << kSeed << "\n";
  Random random{kSeed};
  const CalibratedCell cell = cell_with_deviations(random);
  const std::vector<Measurement> points = readings(cell, 15, random);
  const int size = ParameterLayout::of(cell).size();
  LeastSquaresProblem problem{.points = points, .free = first_parameters(size), .W = {}, .prior = {}};
  problem.turn_weight = turn_weights(points, 0.01);
  const LinearSystem system = linearise(cell, problem);
  const auto R_FT = best_mountings(cell, points, problem.turn_weight);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(45, size + 6);
  Eigen::VectorXd f(45);
  for (int n = 0; n < 15; ++n) {
    const Measurement& point = points[static_cast<std::size_t>(n)];
    const double w = problem.turn_weight[static_cast<std::size_t>(n)];
    PointJacobian turn;
    const Eigen::Matrix3d R_WF = turn_with_jacobian(cell, point.q, turn);
    const Eigen::Matrix3d mounted = *R_FT[static_cast<std::size_t>(point.smr)];
    f.segment<3>(3 * n) = w * R_WF.transpose() * turn_between(point.orientation->R_WT, R_WF * mounted);
    J.block(3 * n, 0, 3, size) = w * R_WF.transpose() * turn;
    J.block<3, 3>(3 * n, size + 3 * point.smr) = w * Eigen::Matrix3d::Identity();
  }
  const Eigen::MatrixXd A = J.transpose() * J;
  const Eigen::VectorXd g = J.transpose() * f;
  const Eigen::MatrixXd eliminated = A.topLeftCorner(size, size) - A.topRightCorner(size, 6) *
                                                                       A.bottomRightCorner<6, 6>().inverse() *
                                                                       A.bottomLeftCorner(6, size);
  const Eigen::VectorXd right =
      g.head(size) - A.topRightCorner(size, 6) * A.bottomRightCorner<6, 6>().inverse() * g.tail<6>();
  const Eigen::MatrixXd ours = system.J.bottomRows(45).transpose() * system.J.bottomRows(45);
  EXPECT_LT((ours - eliminated).norm(), 1e-3 * eliminated.norm());
  EXPECT_LT((system.J.bottomRows(45).transpose() * system.f.tail(45) - right).norm(), 1e-3 * right.norm());
}

/// A campaign of a 6-D target whose positions are read to 10 um and whose turns to so much.
SimulatedCampaign campaign(int identify, std::uint64_t seed, double turn_rad = kTurn_rad,
                           GrossErrors gross = {}) {
  TrueArmSetup arm = example::true_arm();
  arm.R_FT = rotation_by({0.3, -0.8, 1.9});
  return example::campaign(arm, identify, 30, {.gross = gross, .turn_noise_rad = turn_rad, .seed = seed});
}

CalibrateOptions with_noise() {
  CalibrateOptions options;
  options.noise =
      MeasurementNoise{.tracker = {.range_mm = kTrackerNoise_mm, .transverse_mm = kTrackerNoise_mm},
                       .repeatability_mm = kRepeatability_mm};
  return options;
}

TEST(A6DTarget, GivesTheArmAndItsMountingExactlyWhereNothingIsNoisy) {
  TrueArmSetup arm = example::true_arm();
  arm.R_FT = rotation_by({0.3, -0.8, 1.9});
  arm.repeatability_mm = 0;
  SimulatedCampaign exact =
      example::campaign(arm, 20, 20, {.tracker_noise_mm = 0, .turn_noise_rad = 1e-12, .seed = kSeed});
  for (Measurement& point : exact.data.points) point.orientation->sigma_rad = kTurn_rad;
  const auto found = calibrate(example::kr210(), exact.data, with_noise());
  ASSERT_TRUE(found) << found.error().detail;
  EXPECT_LT(found->validate->after.max, 1e-6);
  ASSERT_TRUE(found->mountings[0]);
  ASSERT_TRUE(found->validate->orientation_errors);
  EXPECT_LT(found->validate->orientation_errors->after.max_rad, 1e-9);
  EXPECT_GT(found->validate->orientation_errors->before.mean_rad, 1e-3);
}

TEST(A6DTarget, LeavesAsMuchAsItsReadingsScatterAndNoMore) {
  std::cout << "seed " << kSeed << "\n";
  const SimulatedCampaign measured = campaign(40, kSeed);
  const auto found = calibrate(example::kr210(), measured.data, with_noise());
  ASSERT_TRUE(found) << found.error().detail;
  EXPECT_TRUE(found->rejected.empty());
  EXPECT_EQ(found->rank, 27) << "the mounting takes what the turns would say of the flange's own axes";
  const double stated_mm = std::hypot(kTrackerNoise_mm, kRepeatability_mm);
  EXPECT_NEAR(found->sigma0_mm, stated_mm, 0.2 * stated_mm);
  ASSERT_TRUE(found->validate->orientation_errors);
  EXPECT_NEAR(found->validate->orientation_errors->after.rms_rad, std::sqrt(3) * kTurn_rad, 0.3 * kTurn_rad);
  EXPECT_EQ(found->validate->orientation_errors->readings, 30);
}

TEST(A6DTarget, IsNoWorseForItsOrientationAndBetterFromFewPoses) {
  double alone_mm = 0, with_mm = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SimulatedCampaign measured = campaign(12, seed, 2e-5);
    MeasurementData positions = measured.data;
    for (Measurement& point : positions.points) point.orientation.reset();
    alone_mm += example::mean_miss(calibrate(example::kr210(), positions, with_noise()), measured);
    with_mm += example::mean_miss(calibrate(example::kr210(), measured.data, with_noise()), measured);
  }
  std::cout << "12 poses: positions alone " << alone_mm / 5 << " mm, with orientations " << with_mm / 5
            << " mm\n";
  EXPECT_LT(with_mm, 0.75 * alone_mm);
}

TEST(A6DTarget, ThatSaysAWrongTurnIsNamedAndLeftOut) {
  SimulatedCampaign measured = campaign(40, kSeed);
  measured.data.points[7].orientation->R_WT =
      rotation_by({0, 0.02, 0}) * measured.data.points[7].orientation->R_WT;
  for (const Loss loss : {Loss::OutlierRejection, Loss::Tukey}) {
    CalibrateOptions options = with_noise();
    options.loss = loss;
    const auto found = calibrate(example::kr210(), measured.data, options);
    ASSERT_TRUE(found) << found.error().detail;
    ASSERT_EQ(found->rejected.size(), 1u) << static_cast<int>(loss);
    EXPECT_EQ(found->rejected[0].point, 7u);
    EXPECT_NEAR(found->rejected[0].turn_rad, 0.02, 1e-3);
    EXPECT_LT(example::mean_miss(*found, measured), 0.03);
  }
}

TEST(A6DTarget, NeedsTheNoiseOfItsPositionsToWeighItsTurnsBy) {
  const SimulatedCampaign measured = campaign(20, kSeed);
  const auto refused = calibrate(example::kr210(), measured.data);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, CalibrationFault::NoNoise);
  MeasurementData stated = measured.data;
  for (Measurement& point : stated.points) point.sigma_mm = 0.02;
  EXPECT_TRUE(calibrate(example::kr210(), stated));
}

TEST(A6DTarget, WhoseAnglesAreOfAnotherFrameIsRefused) {
  SimulatedCampaign measured = campaign(20, kSeed);
  for (Measurement& point : measured.data.points)
    point.orientation->R_WT = point.orientation->R_WT.transpose().eval();
  const auto refused = calibrate(example::kr210(), measured.data, with_noise());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, CalibrationFault::WrongTurns);
  EXPECT_NE(refused.error().detail.find("do not follow the arm"), std::string::npos);
}

}  // namespace
}  // namespace truepose
