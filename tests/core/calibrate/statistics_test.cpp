// What holds on average over many trials: the same code again and again, so that a sanitizer learns nothing
// from it.

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <map>

#include "core/calibrate/calibrate.hpp"
#include "core/math/angles.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tests/core/golden.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

Eigen::Matrix3d random_rotation(Random& random) {
  const double w = random.normal(), x = random.normal(), y = random.normal(), z = random.normal();
  return Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
}

/// The campaign as if its outliers had never been measured.
MeasurementData without_gross(const SimulatedCampaign& c) {
  MeasurementData clean = c.data;
  std::size_t i = 0;
  std::erase_if(clean.points, [&](const Measurement&) { return static_cast<bool>(c.gross[i++]); });
  return clean;
}

TEST(CoarseFit, FindsBaseAndReflectorFromEveryRandomPlacement) {
  const auto file = golden::load("identify");
  const RobotModel nominal = golden::nominal(file);
  const RobotModel real = golden::robot(file.at("true_links"), file.at("sign"));
  constexpr std::uint64_t kSeed = 20261121;
  std::cout << "seed " << kSeed << "\n";
  Random random{kSeed};
  int best = 0;
  for (int trial = 0; trial < trials(1000); ++trial) {
    Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
    X_WB.linear() = random_rotation(random);
    X_WB.translation() = random_rotation(random).col(0) * random.uniform(2000, 8000);
    const Eigen::Vector3d p_FS = random_rotation(random).col(0) * random.uniform(0, 500);
    const CalibratedCell truth{real, BasePose::of(X_WB), {{"1", p_FS}}};
    MeasurementData data{.smr_names = {"1"}};
    for (int k = 0; k < 30; ++k) {
      const JointVector q = example::random_joints(nominal, random);
      data.points.push_back({.q = q, .p_WS_mm = truth.predict(q, 0)});
    }
    const auto coarse = coarse_fit(nominal, data);
    ASSERT_TRUE(coarse) << trial << ": " << coarse.error().detail;
    const auto full = calibrate(nominal, data, {.check_model = false});
    // Where the coarse fit is the best minimum, the fine one that starts there leaves nothing.
    best += full && full->identify.geometric.max < 1e-6;
  }
  EXPECT_EQ(best, trials(1000));
}

TEST(Calibrate, StatesASigmaThatCoversTheTruth) {
  // 200 noise draws: the reflector's and the base's identified values lie within 1.96 sigma in 95 % of them.
  const auto file = golden::load("identify");
  const RobotModel nominal = golden::nominal(file);
  MeasurementData data = golden::data_set(file, 0, "true").data;
  const auto noise_free = calibrate(nominal, data);
  ASSERT_TRUE(noise_free);
  Random random{5};
  int inside = 0, all = 0;
  for (int trial = 0; trial < 200; ++trial) {
    MeasurementData noisy = data;
    for (Measurement& m : noisy.points) {
      if (m.set == PoseSet::Identify)
        for (double& coordinate : m.p_WS_mm) coordinate += example::kSigma_mm * random.normal();
    }
    const auto result = calibrate(nominal, noisy, {.check_model = false});
    ASSERT_TRUE(result);
    for (std::size_t k = 0; k < result->parameters.size(); ++k) {
      const IdentifiedParameter& p = result->parameters[k];
      if (!p.identified) continue;
      ++all;
      inside += std::abs(p.value - noise_free->parameters[k].value) < 1.96 * p.sigma;
    }
  }
  EXPECT_NEAR(static_cast<double>(inside) / all, 0.95, 0.02);
}

TEST(RobustLosses, StandGrossErrorsThatRuinLeastSquares) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SimulatedCampaign c =
        example::campaign(example::true_arm(), 40, 30, {.gross = {.fraction = 0.05}, .seed = seed});
    const double oracle = example::mean_miss(calibrate(example::kr210(), without_gross(c)), c);
    EXPECT_GT(example::mean_miss(calibrate(example::kr210(), c.data, {.loss = Loss::Squared}), c),
              10 * oracle);
    for (const Loss loss : {Loss::OutlierRejection, Loss::Tukey, Loss::Igg3, Loss::Huber}) {
      const auto robust = calibrate(example::kr210(), c.data, {.loss = loss});
      EXPECT_LT(example::mean_miss(robust, c),
                (loss == Loss::Tukey || loss == Loss::OutlierRejection ? 1.02 : 1.3) * oracle)
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

TEST(RobustLosses, JudgeByTheRichestModelWhatIsAGrossError) {
  // Compliance alone moves points beyond what the geometry counts as good, and the smaller errors hide in it.
  const RobotModel nominal = example::kr210();
  for (const GrossErrors& gross : {GrossErrors{.fraction = 0.05}, GrossErrors{0.05, 0.3, 2}}) {
    std::map<Loss, double> robust_mm;
    double oracle_mm = 0;
    for (const std::uint64_t seed : {1u, 4u, 5u}) {
      const TrueArmSetup heavy = example::true_arm(heavy_arm_errors({.seed = seed}));
      const SimulatedCampaign c = example::campaign(heavy, 100, 60, {.gross = gross, .seed = seed});
      oracle_mm += example::mean_miss(calibrate(nominal, without_gross(c), {.non_geometric = true}), c);
      for (const Loss loss : {Loss::Tukey, Loss::Igg3, Loss::Huber}) {
        const auto robust = calibrate(nominal, c.data, {.loss = loss, .non_geometric = true});
        robust_mm[loss] += example::mean_miss(robust, c);
        if (!robust || loss == Loss::Huber) continue;
        EXPECT_EQ(robust->rejected.size(), 5u) << "seed " << seed;
        for (const RejectedPoint& point : robust->rejected)
          EXPECT_TRUE(c.gross[point.point]) << "seed " << seed << ", point " << point.point;
      }
    }
    // Huber keeps every point, so each sways it a little.
    for (const auto& [loss, mm] : robust_mm)
      EXPECT_LT(mm, (loss == Loss::Huber ? 1.15 : 1.05) * oracle_mm) << "loss " << static_cast<int>(loss);
  }
}

TEST(Uncertainty, IntervalsHoldTheTruthAsOftenAsTheySay) {
  // 95 % intervals of predicted coordinates over many campaigns.
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(trials(1000)); ++seed) {
    const SimulatedCampaign c = example::campaign(example::true_arm(), 30, 5, {.seed = seed});
    const auto result = calibrate(example::kr210(), c.data, {.prior = PriorUse::Off, .check_model = false});
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
  EXPECT_GT(inside, widened(0.93, -0.03) * all);
  EXPECT_LT(inside, widened(0.97, 0.02) * all);
}

TEST(Prior, KeepsPredictionsSaneWhereThePosesDoNotExciteTheArm) {
  // Orientations within a few degrees and a small workspace: what was not measured must not become worse.
  const RobotModel robot = example::kr210();
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random{seed};
    std::vector<JointVector> narrow;
    for (int k = 0; k < 60; ++k) {
      JointVector q = (JointVector(6) << 0, -90, 90, 10, 30, 0).finished() * kRadPerDeg;
      for (int i = 0; i < 6; ++i) q[i] += random.uniform(-0.08, 0.08);
      narrow.push_back(q);
    }
    const SimulatedCampaign c =
        measure_campaign(example::true_arm(), narrow, random_poses(robot, 50, random), {.seed = seed});
    const auto with = calibrate(robot, c.data);
    const auto without = calibrate(robot, c.data, {.prior = PriorUse::Off});
    ASSERT_TRUE(with && without);
    EXPECT_TRUE(with->prior_used);
    EXPECT_LT(example::mean_miss(with->cell, c), example::mean_miss(with->coarse, c)) << "seed " << seed;
    EXPECT_LT(example::mean_miss(with->cell, c), example::mean_miss(without->cell, c)) << "seed " << seed;
    EXPECT_GT(with->transfer.rms_mm, 10 * with->sigma0_mm) << "and it says that it does not know";
  }
}

TEST(Deviations, IncludeTheSideFromWhichTheJointsArrived) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto errors = heavy_arm_errors({.backlash_rad = 0.002 * kRadPerDeg, .seed = seed});
    const SimulatedCampaign c = example::campaign(example::true_arm(errors), 100, 60, {.seed = seed});
    sum += example::mean_miss(calibrate(example::kr210(), c.data, {.non_geometric = true}), c);
  }
  RecordProperty("mean_mm", std::to_string(sum / 5));
  EXPECT_LT(sum / 5, 0.040);
}

TEST(Layers, AreNotAddedToAnArmThatIsGeometryAlone) {
  double plain = 0, layered = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SimulatedCampaign c = example::campaign(example::true_arm(), 30, 30, {.seed = seed});
    plain += example::mean_miss(calibrate(example::kr210(), c.data), c);
    layered += example::mean_miss(
        calibrate(example::kr210(), c.data, {.non_geometric = true, .field = FieldUse::Auto}), c);
  }
  EXPECT_LT(layered, 1.02 * plain);
}

}  // namespace
}  // namespace truepose
