#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <iostream>

#include "core/arm/forward.hpp"
#include "core/calibrate/calibrate.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/fit/identifiability.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/uncertainty.hpp"
#include "core/math/angles.hpp"
#include "core/math/line_search.hpp"
#include "core/quality/model_noise.hpp"
#include "core/step_count.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/golden.hpp"
#include "tests/core/pose_differences.hpp"

namespace truepose {
namespace {

/// What the arm of the result carries, of points that say that they were measured under these in turn.
std::optional<LinkMass> carried_after(const std::optional<LinkMass>& own,
                                      const std::vector<std::optional<LinkMass>>& stated) {
  Random random{5};
  RobotModel robot = example::kr210();
  robot.masses.resize(6, {100, {0, 0, 0}});
  robot.payload = own;
  MeasurementData data = example::measured(example::placed(robot, random), 20, 0.01, random);
  for (std::size_t i = 0; i < data.points.size(); ++i) data.points[i].payload = stated[i % stated.size()];
  const auto result = calibrate(robot, data, {});
  EXPECT_TRUE(result);
  return result ? result->cell.robot.payload : std::nullopt;
}

TEST(CalibratedArm, CarriesWhatAllPointsSayThatItCarried) {
  const LinkMass gun{150, {0, 0, 200}}, gripper{60, {10, 0, 90}};
  EXPECT_EQ(carried_after(std::nullopt, {gun}), gun);
  EXPECT_EQ(carried_after(gripper, {gun}), gun) << "the points know better than the robot file";
  EXPECT_EQ(carried_after(gripper, {gun, LinkMass{}}), gripper) << "of several none is it";
  EXPECT_EQ(carried_after(std::nullopt, {gun, LinkMass{}}), std::nullopt);
  EXPECT_EQ(carried_after(gripper, {std::nullopt}), gripper);
  EXPECT_EQ(carried_after(gripper, {gun, std::nullopt}), gripper);
}

TEST(MeasurementModel, ReproducesTheGoldenJacobianOfAllThirtyNineParameters) {
  const auto golden = golden::load("jacobian");
  for (const auto& item : golden.at("cases").as_array()) {
    const CalibratedCell cell =
        golden::cell(golden::robot(item.at("links"), golden.at("sign")), item.at("base"), item.at("tool"));
    PointJacobian J;
    const JointVector q = golden::vector(item.at("q"));
    const Eigen::Vector3d point = predict_with_jacobian(cell, q, 0, J);
    EXPECT_LT((point - golden::vector(item.at("point"))).norm(), 1e-9);
    // The golden file differentiates to the Euler angles, the fit turns about the tracker's axes.
    J.middleCols<3>(3) = (J.middleCols<3>(3) * angle_rates_zyx(cell.base.rxyz_rad)).eval();
    const Eigen::MatrixXd expected = golden::matrix(item.at("jacobian"));
    for (Eigen::Index k = 0; k < expected.cols(); ++k) {
      EXPECT_LT((J.col(k) - expected.col(k)).norm(), 1e-11 * (1 + expected.col(k).norm())) << "column " << k;
    }
    const Eigen::MatrixXd joint_jacobian = golden::matrix(item.at("joint_jacobian"));
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d by_q = cell.robot.joints[static_cast<std::size_t>(i)].sign * J.col(9 + 5 * i + 3);
      EXPECT_LT((by_q - joint_jacobian.col(i)).norm(), 1e-11 * (1 + by_q.norm()));
    }
  }
}

TEST(MeasurementModel, AgreesWithDifferencesAndOfManyPosesWithEachForARailWithTwoReflectorsAndAFlange) {
  const RobotModel robot = example::oblique_arm_on_a_rail();
  const CalibratedCell cell{
      robot, {{1000, -2000, 300}, {0.3, 1.2, -2}}, {{"a", {10, 20, 30}}, {"b", {-40, 5, 60}}}};
  Random random{3};
  const JointVector q = example::random_joints(robot, random);
  PointJacobian J;
  const Eigen::Vector3d point = predict_with_jacobian(cell, q, 1, J);
  EXPECT_LT((point - cell.predict(q, 1)).norm(), 1e-10);
  expect_differences(cell, q, 1, J);

  std::vector<JointVector> poses;
  for (int n = 0; n < 70; ++n) poses.push_back(example::random_joints(robot, random));
  Eigen::VectorXd points;
  Eigen::MatrixXd rows;
  predict_with_jacobian(cell, poses, points, rows);
  for (std::size_t n = 0; n < poses.size(); ++n) {
    const auto row = static_cast<Eigen::Index>(3 * n);
    EXPECT_LT((points.segment<3>(row) - predict_with_jacobian(cell, poses[n], 0, J)).norm(), 1e-9);
    EXPECT_LT((rows.middleRows<3>(row) - J).norm(), 1e-12 * J.norm());
  }
}

TEST(LineSearch, MeetsArmijoAndStrongWolfeOnFunctionsThatRejectTheFullStep) {
  const auto check = [](const std::function<LinePoint(double)>& line) {
    const LinePoint start = line(0);
    const auto step = strong_wolfe_step(line, start);
    ASSERT_TRUE(step);
    EXPECT_LE(line(*step).value, start.value + 1e-4 * *step * start.slope);
    EXPECT_LE(std::abs(line(*step).slope), 0.9 * std::abs(start.slope));
  };
  check([](double s) { return LinePoint{(s - 0.01) * (s - 0.01), 2 * (s - 0.01)}; });
  check([](double s) { return LinePoint{(s - 300) * (s - 300), 2 * (s - 300)}; });
  check([](double s) { return LinePoint{std::cos(3 * s) - 0.1 * s, -3 * std::sin(3 * s) - 0.1}; });
  check([](double s) { return LinePoint{-s / (s * s + 2), (s * s - 2) / ((s * s + 2) * (s * s + 2))}; });
}

TEST(LineSearch, FindsNoStepUphillOrIntoNaN) {
  EXPECT_FALSE(strong_wolfe_step([](double s) { return LinePoint{s, 1}; }, {0, 1}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(strong_wolfe_step([&](double) { return LinePoint{nan, nan}; }, {0, -1}));
}

TEST(Calibrate, ReachesTheGoldenOptimumOfEveryDataSet) {
  const auto file = golden::load("identify");
  for (std::size_t set = 0; set < 4; ++set) {
    const auto [expected, data] = golden::data_set(file, set, "true");
    const auto result = calibrate(golden::nominal(file), data);
    ASSERT_TRUE(result) << result.error().detail;
    EXPECT_TRUE(result->converged);
    EXPECT_EQ(result->rank, 27);
    EXPECT_GT(result->rank_gap, 1e3);
    EXPECT_LE(result->fine_iterations, 4);
    const auto near = [&](double value, const char* key) {
      EXPECT_NEAR(value, golden::number(expected.at(key)), 1e-8) << "set " << set << " " << key;
    };
    near(result->identify.before.rms, "coarse_residual_rms_3d");
    near(result->identify.geometric.rms, "fine_residual_rms_3d");
    near(result->validate->geometric.rms, "validation_rmse_3d_vs_true");
    near(result->validate->geometric.mean, "validation_mean_vs_true");
    near(result->validate->geometric.max, "validation_max_vs_true");
    near(result->validate->before.mean, "validation_mean_after_coarse_only");

    // The same columns are kept, so the printed parameters agree too.
    std::vector<std::string> kept;
    for (const IdentifiedParameter& p : result->parameters) {
      if (p.identified) kept.push_back(p.name);
    }
    const Eigen::VectorXd fine = golden::vector(expected.at("fine_vector"));
    const Eigen::VectorXd values = parameter_values(result->cell);
    EXPECT_LT((values - fine).cwiseAbs().maxCoeff(), 1e-6) << "set " << set;
    EXPECT_EQ(kept.size(), 27U);
  }
}

/// What the product's speed rests on: whatever is weighed, whitened, held by a prior or deviates.
TEST(Calibrate, SolvesItsStepsByTheKernels) {
  const auto file = golden::load("identify");
  const MeasurementData data = golden::data_set(file, 1, "true").data;
  CalibrateOptions noise, robust, prior, deviation;
  noise.noise = MeasurementNoise{.tracker = {0.005, 0.001, 0.01, 0.004}, .repeatability_mm = 0.02};
  robust.loss = Loss::Tukey;
  prior.prior = PriorUse::On;
  deviation.non_geometric = true;
  for (const CalibrateOptions& options : {CalibrateOptions{}, noise, robust, prior, deviation}) {
    const auto result = calibrate(golden::nominal(file), data, options);
    ASSERT_TRUE(result) << result.error().detail;
    EXPECT_EQ(result->fine_solver, StepSolver::NormalEquations);
  }
}

/// A calibrated KR 210, measured by a tracker at random poses.
MeasurementData noisy_data(int poses) {
  const CalibratedCell truth{example::with_paper_errors(example::kr210()),
                             {{3500, -800, -150}, {0.02, -0.01, 2.4}},
                             {{"1", {40, -30, 120}}}};
  MeasurementData data{.smr_names = {"1"}};
  Random random{8};
  for (int n = 0; n < poses; ++n) {
    const JointVector q = example::random_joints(truth.robot, random);
    const Eigen::Vector3d noise_mm(random.normal(), random.normal(), random.normal());
    data.points.push_back({.q = q, .p_WS_mm = truth.predict(q, 0) + 0.02 * noise_mm});
  }
  return data;
}

/// How many fits and evaluations a calibration takes, in steps.
std::uint64_t steps_of(const MeasurementData& data) {
  std::atomic<std::uint64_t> steps{0};
  step_count = &steps;
  const auto calibration = calibrate(example::kr210(), data);
  step_count = nullptr;
  EXPECT_TRUE(calibration && calibration->converged);
  return steps;
}

TEST(Calibrate, LooksForMistakesAndGrossErrorsByManyFitsOnlyWhereAPlainOneLeavesAnyDoubt) {
  MeasurementData data = noisy_data(60);
  const std::uint64_t right = steps_of(data);
  EXPECT_LT(right, 20u);
  for (const double off_mm : {0.2, 5.0}) {
    data.points[17].p_WS_mm.x() += off_mm;
    EXPECT_GT(steps_of(data), 5 * right);
    EXPECT_EQ(calibrate(example::kr210(), data)->rejected.size(), 1u);
    data.points[17].p_WS_mm.x() -= off_mm;
  }
}

TEST(Calibrate, LeavesNothingOfNoiseFreeErrorsAtFreshPoses) {
  const auto file = golden::load("identify");
  const auto result = calibrate(golden::nominal(file), golden::data_set(file, 0, "true").data);
  ASSERT_TRUE(result);
  EXPECT_LT(result->validate->geometric.max, 1e-8);
}

/// An arm whose gears are out of round, which the geometry does not describe: more points make nothing of it
/// better.
struct OutOfRoundArm {
  explicit OutOfRoundArm(std::uint64_t seed)
      : random{seed}, truth{example::placed(example::with_paper_errors(example::kr210()), random)} {}

  static JointVector encoder_reading(const JointVector& q) { return q.array() - 3e-4 * q.array().sin(); }
  MeasurementData measured(int poses, double sigma_mm) {
    MeasurementData data = example::measured(truth, poses, sigma_mm, random);
    for (Measurement& point : data.points) point.q = encoder_reading(point.q);
    return data;
  }
  /// RMS over poses that were not measured.
  double error_mm(const CalibratedCell& model) {
    double squares = 0;
    const std::vector<JointVector> fresh = poses_within_limits(truth.robot, 300, random.next());
    for (const JointVector& q : fresh)
      squares += (model.predict(encoder_reading(q), 0) - truth.predict(q, 0)).squaredNorm();
    return std::sqrt(squares / static_cast<double>(fresh.size()));
  }

  Random random;
  CalibratedCell truth;
};

TEST(Calibrate, TellsOfUnmeasuredPosesWhatItsModelLeavesToo) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    OutOfRoundArm arm(seed);
    const auto made = calibrate(example::kr210(), arm.measured(400, example::kSigma_mm),
                                {.noise = MeasurementNoise{.repeatability_mm = example::kSigma_mm}});
    ASSERT_TRUE(made) << made.error().detail;
    const double rms_mm = arm.error_mm(made->cell);
    EXPECT_GT(made->transfer.rms_mm, rms_mm / 1.3) << "seed " << seed;
    EXPECT_LT(made->transfer.rms_mm, rms_mm * 1.3) << "seed " << seed;
    const JointVector q = JointVector::Constant(6, 0.3);
    EXPECT_NEAR(std::sqrt(made->position_covariance(q, 0).trace()), rms_mm, 0.3 * rms_mm) << "seed " << seed;
  }
}

TEST(NoiseAboutAModel, CountsWhatTheModelLeavesToTheArmAndNotToTheTracker) {
  constexpr double kTracker_mm = 0.1;
  const MeasurementNoise stated{.tracker = {.range_mm = kTracker_mm, .transverse_mm = kTracker_mm}};
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    OutOfRoundArm arm(seed);
    const MeasurementData data = arm.measured(400, kTracker_mm);
    const auto made = calibrate(example::kr210(), data, {.noise = stated});
    ASSERT_TRUE(made) << made.error().detail;
    const MeasurementNoise about = noise_about_model(*made, data, stated);
    EXPECT_EQ(about.tracker.transverse_mm, kTracker_mm);
    const double rms_mm = arm.error_mm(made->cell);
    EXPECT_NEAR(std::sqrt(3.0) * about.repeatability_mm, rms_mm, 0.3 * rms_mm) << "seed " << seed;
  }
}

TEST(NoiseAboutAModel, IsThatOfThePointsWhereTheyScatterLessThanStated) {
  Random random{4};
  const CalibratedCell truth = example::placed(example::kr210(), random);
  const MeasurementData data = example::measured(truth, 100, 0.02, random);
  const MeasurementNoise stated{.tracker = {.range_mm = 0.04, .transverse_mm = 0.04},
                                .repeatability_mm = 0.06};
  const auto made = calibrate(example::kr210(), data, {.noise = stated});
  ASSERT_TRUE(made) << made.error().detail;
  const MeasurementNoise about = noise_about_model(*made, data, stated);
  EXPECT_NEAR(std::hypot(about.repeatability_mm, about.tracker.range_mm), 0.02, 0.003);
  EXPECT_NEAR(about.repeatability_mm / about.tracker.range_mm, 1.5, 1e-9);
}

TEST(CoarseFit, NeedsFewPosesToAimWith) {
  const auto file = golden::load("identify");
  MeasurementData data = golden::data_set(file, 0, "true").data;
  data.points.resize(6);
  const auto coarse = coarse_fit(golden::nominal(file), data);
  ASSERT_TRUE(coarse);
  const MeasurementData all = golden::data_set(file, 0, "true").data;
  for (const Measurement& m : all.points) EXPECT_LT((coarse->predict(m.q, 0) - m.p_WS_mm).norm(), 60);
}

TEST(Calibrate, SaysWhichDataItCannotUse) {
  const auto file = golden::load("identify");
  const RobotModel nominal = golden::nominal(file);
  const MeasurementData good = golden::data_set(file, 0, "true").data;

  MeasurementData few = good;
  few.points.resize(4);
  EXPECT_EQ(calibrate(nominal, few).error().detail,
            "4 poses to identify from; base and reflector alone need 5");
  few = good;
  few.points.resize(8);
  const auto without_prior = calibrate(nominal, few, {.prior = PriorUse::Off});
  ASSERT_FALSE(without_prior);
  EXPECT_EQ(without_prior.error().fault, CalibrationFault::TooFewPoses);

  MeasurementData nan = good;
  nan.points[2].p_WS_mm.x() = std::numeric_limits<double>::quiet_NaN();
  nan.points[2].row = 3;
  EXPECT_EQ(calibrate(nominal, nan).error().detail, "row 3 holds a number that is not finite");

  MeasurementData second = good;
  second.smr_names.push_back("2");
  EXPECT_EQ(calibrate(nominal, second).error().detail, "reflector '2' has no point to identify it from");
}

/// Three prismatic joints that never turn the flange.
RobotModel gantry() {
  RobotModel robot{.name = "gantry"};
  for (int i = 0; i < 3; ++i) {
    robot.joints.push_back({.type = JointType::Prismatic,
                            .alpha_rad = std::numbers::pi / 2,
                            .theta_rad = std::numbers::pi / 2,
                            .min = 0,
                            .max = 2000});
  }
  return robot;
}

TEST(Calibrate, KeepsAReflectorAtTheFlangeThatNoTurnOfItShowsAndSaysSo) {
  const CalibratedCell truth{gantry(), {{2000, 1000, 0}, {0.1, 0.2, 0.3}}, {{"1", {50, 60, 70}}}};
  Random random{1};
  const auto result = calibrate(gantry(), example::measured(truth, 30, 0, random));
  ASSERT_TRUE(result) << result.error().detail;
  EXPECT_LT(result->identify.after.max, 1e-6);
  EXPECT_LT(result->cell.reflectors[0].p_FS_mm.norm(), 1e-6);
  const auto tells = [](const Combination& c) { return c.sentence.find("smr.1") != std::string::npos; };
  EXPECT_EQ(std::ranges::count_if(result->unknown, tells), 1);
  EXPECT_TRUE(
      result->unknown.front().sentence.ends_with("cannot be separated from base.x, base.y and base.z"));
}

TEST(Calibrate, RefusesPosesThatDoNotShowHowTheBaseIsTurned) {
  const CalibratedCell truth{gantry(), {{2000, 1000, 0}, {0.1, 0.2, 0.3}}, {{"1", {50, 60, 70}}}};
  Random random{1};
  MeasurementData line = example::measured(truth, 30, 0, random);
  for (Measurement& point : line.points) {
    point.q.head<2>().setConstant(500);
    point.p_WS_mm = truth.predict(point.q, 0);
  }
  const auto result = calibrate(gantry(), line);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().fault, CalibrationFault::NotSeparable);
  EXPECT_TRUE(result.error().detail.starts_with("the poses do not show how the base is turned"))
      << result.error().detail;
}

TEST(Calibrate, WeighsPointsByTheirSigma) {
  const auto file = golden::load("identify");
  MeasurementData data = golden::data_set(file, 0, "true").data;
  for (std::size_t i = 0; i < data.points.size(); ++i) data.points[i].sigma_mm = i % 5 ? 0.01 : 10.0;
  for (std::size_t i = 0; i < 30; i += 5) data.points[i].p_WS_mm.x() += 5;
  const auto result = calibrate(golden::nominal(file), data);
  ASSERT_TRUE(result);
  EXPECT_LT(result->validate->geometric.max, 0.05) << "bad points that say so do little harm";
}

}  // namespace
}  // namespace truepose
