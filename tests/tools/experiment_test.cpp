#include "tools/experiment/experiment.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "config/robot_file.hpp"
#include "core/simulate/published_arm.hpp"
#include "tools/experiment/regression_methods.hpp"
#include "tools/experiment/trial.hpp"

namespace truepose {
namespace {

ExperimentOptions small() {
  return {.seed = 1,
          .trials = 8,
          .design_candidates = 300,
          .layer_trials = 1,
          .layer_targets = 100,
          .layer_poses = {100},
          .backlash_deg = {0.002}};
}

const ExperimentResult& result() {
  static const ExperimentResult once = *run_experiment(published_arm(), small());
  return once;
}

const MethodResult& method(const std::string& name, TrialData data) {
  return *std::ranges::find_if(result().methods,
                               [&](const MethodResult& m) { return m.method == name && m.data == data; });
}

const LayerResult& layer(const std::string& name, bool rigid) {
  return *std::ranges::find_if(result().layers,
                               [&](const LayerResult& l) { return l.layer == name && l.rigid == rigid; });
}

TEST(Experiment, ReachesTheBoundByTwoStagesAndNothingIsLeftWithoutNoise) {
  EXPECT_NEAR(method("two-stage", TrialData::Noisy).rmse_over_bound, 1, 0.15);
  EXPECT_EQ(method("two-stage", TrialData::Noisy).converged, 1);
  EXPECT_LT(method("two-stage", TrialData::NoiseFree).validation->max, 1e-9);
}

TEST(Experiment, ShowsWhatGrossErrorsDoAndThatTheRobustFitDoesNotMind) {
  EXPECT_GT(method("two-stage", TrialData::GrossErrors).validation->mean, 1);
  EXPECT_EQ(method("oracle", TrialData::GrossErrors).within_2_percent_of_oracle, 1);
  EXPECT_EQ(method("robust two-stage (tukey)", TrialData::GrossErrors).within_2_percent_of_oracle, 1);
}

TEST(Experiment, ShowsThatChosenPosesPredictBetterThanRandomOnes) {
  const auto& designs = result().designs;
  ASSERT_EQ(designs.size(), 3u);
  EXPECT_EQ(designs[0].design, "random");
  for (std::size_t k = 1; k < 3; ++k) {
    EXPECT_LT(designs[k].rms_mm, designs[0].rms_mm);
    EXPECT_GT(designs[k].max_mm, designs[k].rms_mm);
  }
}

TEST(Experiment, ExplainsThePublishedFiguresByWhatTheFitLost) {
  const auto& pairs = result().published;
  ASSERT_EQ(pairs.size(), 6u);
  EXPECT_NEAR(pairs[0].mean_mm / pairs[0].published_mean_mm, 1, 0.3);
  EXPECT_NEAR(pairs[1].mean_mm / pairs[1].published_mean_mm, 1, 0.3);
  EXPECT_LT(pairs[2].mean_mm, 0.03);
}

TEST(Experiment, SaysWhichAssumptionsWereChosenToMatchThePublishedFigures) {
  const auto& pairs = result().published;
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NE(pairs[k].explanation.find("chosen to match"), std::string::npos);
    EXPECT_NE(pairs[k].explanation.find("40 %"), std::string::npos);
  }
  EXPECT_NE(pairs[0].explanation.find("0.4 mm and 0.4 mrad"), std::string::npos);
  for (std::size_t k = 3; k < 6; ++k)
    EXPECT_NE(pairs[k].explanation.find("not a reproduction"), std::string::npos);
}

TEST(Experiment, OrdersTheQuartilesOfEveryMethodAndShowsHowItConverged) {
  for (const MethodResult& m : result().methods) {
    if (m.converged == 0) continue;
    const auto [lower, median, upper] = m.quartiles_mm.value();
    EXPECT_LE(m.validation->min, lower) << m.method;
    EXPECT_LT(lower, median) << m.method;
    EXPECT_LT(median, upper) << m.method;
    EXPECT_LE(upper, m.validation->max) << m.method;
  }
  const auto& curve = method("two-stage from the guess", TrialData::Noisy).convergence_mm;
  ASSERT_GT(curve.size(), 3u);
  EXPECT_GT(curve.front(), 100);
  EXPECT_LT(curve.back(), 0.05);
}

TEST(Experiment, ShowsWhatEachLayerBuysOnAHeavyArmAndThatInversionBuysNothing) {
  const double geometric = layer("geometric", false).validation.mean;
  EXPECT_NEAR(layer("inverted", false).validation.mean / geometric, 1, 0.1);
  EXPECT_LT(layer("compliance", false).validation.mean, 0.5 * geometric);
  EXPECT_LT(layer("compliance and harmonics", false).validation.mean,
            layer("compliance", false).validation.mean);
  EXPECT_LT(layer("non-geometric auto", false).validation.mean, 0.045);
  EXPECT_LT(layer("geometric", true).validation.mean, 0.04);
  EXPECT_GT(layer("nominal", true).validation.mean, 1);
}

TEST(Experiment, ShowsWhatAResidualFieldBuysOnGeometryAndThatDeviationsLeaveItLittle) {
  const double geometric = layer("geometric", false).validation.mean;
  EXPECT_LT(layer("geometric and gp", false).validation.mean, 0.9 * geometric);
  for (const RegressionMethod* method : kRegressionMethods)
    EXPECT_GT(layer("geometric and " + std::string(method->name), false).validation.mean,
              layer("non-geometric auto", false).validation.mean);
  EXPECT_NEAR(layer("non-geometric auto and gp", false).validation.mean,
              layer("non-geometric auto", false).validation.mean, 0.005);
}

TEST(PublishedArm, IsTheOneOfTheRobotFile) {
  const RobotModel arm = published_arm();
  const RobotModel file = config::load_robot(TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml");
  EXPECT_EQ(arm.name, file.name);
  EXPECT_TRUE(arm.X_flange.isApprox(file.X_flange, 1e-15));
  ASSERT_EQ(arm.joints.size(), file.joints.size());
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    const Joint &a = arm.joints[i], &b = file.joints[i];
    EXPECT_EQ(a.type, b.type);
    for (const auto member : {&Joint::a_mm, &Joint::alpha_rad, &Joint::d_mm, &Joint::theta_rad,
                              &Joint::beta_rad, &Joint::sign, &Joint::min, &Joint::max, &Joint::speed})
      EXPECT_DOUBLE_EQ(a.*member, b.*member) << "joint " << i + 1;
  }
}

TEST(Experiment, RefusesAnArmThatThePublishedErrorsDoNotFit) {
  RobotModel seven = published_arm();
  seven.joints.push_back(seven.joints.back());
  const auto refused = run_experiment(seven, small());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().find("six revolute joints"), std::string::npos);
}

TEST(Trial, IsTheSameForTheSameSeedAndAnotherForTheNext) {
  const Trial first = draw_trial(published_arm(), small(), 3),
              again = draw_trial(published_arm(), small(), 3), next = draw_trial(published_arm(), small(), 4);
  EXPECT_EQ(first.truth.base.p_mm, again.truth.base.p_mm);
  EXPECT_EQ(first.identify.front(), again.identify.front());
  EXPECT_NE(first.identify.front(), next.identify.front());
  EXPECT_NE(first.noise_seed, next.noise_seed);
}

TEST(TargetMotion, FindsTheJointsThatPutTheReflectorOnAPoint) {
  const Trial trial = draw_trial(published_arm(), small(), 0);
  const JointVector q{{0.3, -1.2, 1.4, 0.5, 0.7, -0.4}};
  const Eigen::Vector3d wanted = trial.truth.predict(q, 0) + Eigen::Vector3d{1, -2, 1.5};
  const auto found = joints_for_reflector(trial.truth, wanted, q, {});
  ASSERT_TRUE(found);
  EXPECT_LT((trial.truth.predict(*found, 0) - wanted).norm(), 1e-6);
  EXPECT_LT((*found - q).norm(), 0.01);
  EXPECT_FALSE(joints_for_reflector(trial.truth, wanted + Eigen::Vector3d{0, 0, 9000}, q, {}));
}

TEST(TargetMotion, BringsAWrongArmToTheTargetByTheTrackerAlone) {
  const Trial trial = draw_trial(published_arm(), small(), 0);
  TrueArm arm{{.robot = trial.truth.robot,
               .X_WB = trial.truth.base.isometry(),
               .p_FS_mm = trial.truth.reflectors.front().p_FS_mm},
              1};
  const CalibratedCell nominal{published_arm(), trial.truth.base, trial.truth.reflectors};
  const JointVector q{{0.3, -1.2, 1.4, 0.5, 0.7, -0.4}};
  const Eigen::Vector3d wanted = nominal.predict(q, 0);
  EXPECT_GT((arm.p_WS_mm(q) - wanted).norm(), 3);
  Random random{1};
  EXPECT_LT((approach_with_tracker(arm, nominal, wanted, q, {}, random) - wanted).norm(), 0.05);
}

}  // namespace
}  // namespace truepose
