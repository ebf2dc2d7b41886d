// What calibrate() makes of data that are not as the plain method wants them.

#include <gtest/gtest.h>

#include <cmath>

#include "config/robot_file.hpp"
#include "core/calibration/calibrate.hpp"
#include "core/calibration/measurement_noise.hpp"
#include "core/calibration/robust_loss.hpp"
#include "core/kinematics/angles.hpp"
#include "core/simulation/measurement_campaign.hpp"
#include "core/simulation/published_errors.hpp"

namespace truepose {
namespace {

RobotModel kr210() { return config::load_robot(TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml"); }

TrueArmSetup arm(NonGeometricErrors errors = {}) {
  TrueArmSetup setup{.robot = with_published_errors(kr210()),
                     .non_geometric = std::move(errors),
                     .p_FS_mm = {80, 40, 120},
                     .repeatability_mm = kRepeatability_mm};
  setup.X_WB.translation() = Eigen::Vector3d{4000, 500, -300};
  setup.X_WB.rotate(Eigen::AngleAxisd{2.1, Eigen::Vector3d::UnitZ()});
  return setup;
}

SimulatedCampaign campaign(const TrueArmSetup& setup, int identify, int validate, CampaignOptions options) {
  Random random{options.seed + 1000};
  const RobotModel robot = kr210();
  const auto measured = random_poses(robot, identify, random);
  return measure_campaign(setup, measured, random_poses(robot, validate, random), options);
}

/// Mean distance (mm) between what a cell predicts for the validation poses and where the arm truly stands
/// there.
double mean_miss(const CalibratedCell& cell, const SimulatedCampaign& c) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < c.data.points.size(); ++i) {
    const Measurement& m = c.data.points[i];
    if (m.set != PoseSet::Validate) continue;
    sum += (cell.predict(m.q, m.smr, m.direction) - c.p_true_mm[i]).norm();
    ++count;
  }
  return sum / count;
}

double mean_miss(const std::expected<Calibration, CalibrationError>& calibration,
                 const SimulatedCampaign& c) {
  EXPECT_TRUE(calibration.has_value()) << (calibration ? "" : calibration.error().detail);
  return calibration ? mean_miss(calibration->cell, c) : HUGE_VAL;
}

TEST(Methods, AllEndAtTheSameArmFromASaneStart) {
  const SimulatedCampaign c = campaign(arm(), 30, 30, {.seed = 1});
  const double two_stage = mean_miss(calibrate(kr210(), c.data), c);
  EXPECT_LT(two_stage, 0.03);
  for (const auto method : {CalibrationMethod::LeastSquares, CalibrationMethod::GaussNewton,
                            CalibrationMethod::LevenbergMarquardt, CalibrationMethod::ParticleSwarm}) {
    const auto result = calibrate(kr210(), c.data, {.method = method});
    EXPECT_NEAR(mean_miss(result, c), two_stage, 1e-4) << static_cast<int>(method);
    EXPECT_TRUE(result && result->converged) << static_cast<int>(method);
  }
  EXPECT_LT(mean_miss(calibrate(kr210(), c.data, {.method = CalibrationMethod::Ridge}), c), 1.2 * two_stage);
}

TEST(RobustLosses, StandGrossErrorsThatRuinLeastSquares) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SimulatedCampaign c = campaign(arm(), 40, 30, {.gross = {.fraction = 0.05}, .seed = seed});
    MeasurementData clean = c.data;
    std::size_t i = 0;
    std::erase_if(clean.points, [&](const Measurement&) { return static_cast<bool>(c.gross[i++]); });
    const double oracle = mean_miss(calibrate(kr210(), clean), c);
    EXPECT_GT(mean_miss(calibrate(kr210(), c.data), c), 10 * oracle);
    for (const Loss loss : {Loss::Tukey, Loss::Igg3, Loss::Huber}) {
      const auto robust = calibrate(kr210(), c.data, {.loss = loss});
      EXPECT_LT(mean_miss(robust, c), (loss == Loss::Tukey ? 1.02 : 1.3) * oracle)
          << "seed " << seed << ", loss " << static_cast<int>(loss);
      if (!robust || loss == Loss::Huber) continue;
      ASSERT_EQ(robust->rejected.size(), 2u) << "seed " << seed;
      for (const RejectedPoint& point : robust->rejected) {
        EXPECT_TRUE(c.gross[point.point]);
        EXPECT_GT(point.residual_mm, 4);
        EXPECT_GT(point.sigmas, 5);
      }
    }
  }
}

TEST(RobustLosses, ChangeNothingWhereNothingIsWrong) {
  const SimulatedCampaign c = campaign(arm(), 60, 30, {.seed = 5});
  const auto plain = calibrate(kr210(), c.data);
  const auto tukey = calibrate(kr210(), c.data, {.loss = Loss::Tukey});
  ASSERT_TRUE(plain && tukey);
  EXPECT_TRUE(tukey->rejected.empty());
  EXPECT_NEAR(mean_miss(tukey->cell, c), mean_miss(plain->cell, c), 1e-6);
}

TEST(RobustLosses, WeighAsTheyArePublished) {
  EXPECT_EQ(huber_weight(2.5, 2.5), 1);
  EXPECT_DOUBLE_EQ(huber_weight(5, 2.5), 0.5);
  EXPECT_EQ(igg3_weight(3, 3, 6), 1);
  EXPECT_DOUBLE_EQ(igg3_weight(4.5, 3, 6), 3 / 4.5 * 0.25);
  EXPECT_EQ(igg3_weight(6, 3, 6), 0);
  EXPECT_DOUBLE_EQ(tukey_weight(3, 6), 0.5625);
  EXPECT_EQ(tukey_weight(7, 6), 0);
  const double lengths[] = {100, 1.5381722544550522, 0.1};
  EXPECT_DOUBLE_EQ(sigma_from_median(lengths), 1);
}

TEST(Noise, AlongTheBeamIsNotAcrossIt) {
  const MeasurementNoise noise{.tracker = {.range_mm = 0.002, .transverse_mm_per_m = 0.01},
                               .repeatability_mm = 0.003};
  const Eigen::Matrix3d covariance = reading_covariance({3000, 0, 0}, noise);
  EXPECT_NEAR(covariance(0, 0), 0.002 * 0.002 + 0.003 * 0.003, 1e-15);
  EXPECT_NEAR(covariance(1, 1), 0.03 * 0.03 + 0.003 * 0.003, 1e-15);
  EXPECT_NEAR(covariance(0, 1), 0, 1e-15);
}

TEST(Noise, TheModelMakesResidualsAlike) {
  const Measurement near{.p_WS_mm = {0, 2000, 0}}, far{.p_WS_mm = {3000, 4000, 0}};
  const MeasurementNoise noise{.tracker = {.range_mm = 0.002, .transverse_mm_per_m = 0.01}};
  const Measurement points[] = {near, far};
  const Whitening whitening = whitening_of(points, noise);
  EXPECT_NEAR(whitening.finest_mm, 0.002, 1e-12);
  const Eigen::Vector3d one_sigma_along = Eigen::Vector3d(0.6, 0.8, 0) * 0.002;
  EXPECT_NEAR((whitening.W[1] * one_sigma_along).norm(), 0.002, 1e-12);
  EXPECT_NEAR((whitening.W[1] * Eigen::Vector3d(0, 0, 0.05)).norm(), 0.002, 1e-12);
  EXPECT_NEAR((whitening.W[0] * Eigen::Vector3d(0.02, 0, 0)).norm(), 0.002, 1e-12);
}

TEST(Uncertainty, IntervalsHoldTheTruthAsOftenAsTheySay) {
  // 95 % intervals of predicted coordinates over many campaigns.
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const SimulatedCampaign c = campaign(arm(), 30, 5, {.seed = seed});
    const auto result = calibrate(kr210(), c.data, {.prior = PriorUse::Off, .check_model = false});
    ASSERT_TRUE(result);
    for (std::size_t i = 30; i < 35; ++i) {
      const Measurement& m = c.data.points[i];
      const Eigen::Matrix3d covariance = result->position_covariance(m.q, 0);
      const Eigen::Vector3d off = result->cell.predict(m.q, 0) - c.p_true_mm[i];
      for (int k = 0; k < 3; ++k) {
        ++all;
        inside += std::abs(off[k]) < 1.998 * std::sqrt(covariance(k, k));  // t with 63 degrees of freedom
      }
    }
  }
  EXPECT_GT(inside, 0.93 * all);
  EXPECT_LT(inside, 0.97 * all);
}

TEST(Prior, StaysAwayWhereThePosesExciteTheArm) {
  const SimulatedCampaign c = campaign(arm(), 40, 30, {.seed = 7});
  const auto result = calibrate(kr210(), c.data);
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->prior_used);
  for (const IdentifiedParameter& p : result->parameters)
    EXPECT_EQ(p.data_share, p.identified ? 1 : 0) << p.name;
}

TEST(Prior, KeepsPredictionsSaneWhereThePosesDoNotExciteTheArm) {
  // Orientations within a few degrees and a small workspace: what was not measured must not become worse.
  const RobotModel robot = kr210();
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random{seed};
    std::vector<JointVector> narrow;
    for (int k = 0; k < 60; ++k) {
      JointVector q = (JointVector(6) << 0, -90, 90, 10, 30, 0).finished() * kRadPerDeg;
      for (int i = 0; i < 6; ++i) q[i] += random.uniform(-0.08, 0.08);
      narrow.push_back(q);
    }
    const SimulatedCampaign c =
        measure_campaign(arm(), narrow, random_poses(robot, 50, random), {.seed = seed});
    const auto with = calibrate(robot, c.data);
    const auto without = calibrate(robot, c.data, {.prior = PriorUse::Off});
    ASSERT_TRUE(with && without);
    EXPECT_TRUE(with->prior_used);
    EXPECT_LT(mean_miss(with->cell, c), mean_miss(with->coarse, c)) << "seed " << seed;
    EXPECT_LT(mean_miss(with->cell, c), mean_miss(without->cell, c)) << "seed " << seed;
    EXPECT_GT(with->transfer.rms_mm, 10 * with->sigma0_mm) << "and it says that it does not know";
  }
}

TEST(Deviations, OfAHeavyArmAreFoundDownToItsRepeatability) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SimulatedCampaign c = campaign(arm(heavy_arm_errors({.seed = seed})), 100, 60, {.seed = seed});
    const auto result = calibrate(kr210(), c.data, {.deviation = true});
    sum += mean_miss(result, c);
    EXPECT_GT(mean_miss(result->geometric, c), 0.2);
    EXPECT_TRUE(result->converged);
  }
  RecordProperty("mean_mm", std::to_string(sum / 5));
  EXPECT_LT(sum / 5, 0.035);
}

TEST(Deviations, IncludeTheSideFromWhichTheJointsArrived) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto errors = heavy_arm_errors({.backlash_rad = 0.002 * kRadPerDeg, .seed = seed});
    const SimulatedCampaign c = campaign(arm(errors), 100, 60, {.seed = seed});
    sum += mean_miss(calibrate(kr210(), c.data, {.deviation = true}), c);
  }
  RecordProperty("mean_mm", std::to_string(sum / 5));
  EXPECT_LT(sum / 5, 0.040);
}

TEST(Layers, AreNotAddedToAnArmThatIsGeometryAlone) {
  double plain = 0, layered = 0;
  const std::vector<RegressorKind> kinds{RegressorKind::GaussianProcess, RegressorKind::InverseDistance};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SimulatedCampaign c = campaign(arm(), 30, 30, {.seed = seed});
    plain += mean_miss(calibrate(kr210(), c.data), c);
    layered += mean_miss(calibrate(kr210(), c.data, {.deviation = true, .residual = kinds}), c);
  }
  EXPECT_LT(layered, 1.02 * plain);
}

TEST(ResidualFields, ExplainWhatAGeometricModelLeaves) {
  const SimulatedCampaign c = campaign(arm(heavy_arm_errors({.seed = 3})), 100, 60, {.seed = 3});
  const auto result = calibrate(kr210(), c.data, {.residual = {RegressorKind::GaussianProcess}});
  ASSERT_TRUE(result);
  ASSERT_TRUE(result->cell.robot.field);
  EXPECT_LT(mean_miss(result->cell, c), 0.7 * mean_miss(result->geometric, c));
  EXPECT_LT(result->validate->after.mean, result->validate->geometric.mean);
}

}  // namespace
}  // namespace truepose
