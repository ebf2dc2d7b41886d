// What calibrate() makes of data that are not as the plain method wants them.

#include <gtest/gtest.h>

#include "core/calibrate/calibrate.hpp"
#include "core/data/measurement.hpp"
#include "core/fit/robust_fit.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"

namespace truepose {
namespace {

TEST(RobustLosses, ChangeNothingWhereNothingIsWrong) {
  const SimulatedCampaign c = example::campaign(example::true_arm(), 60, 30, {.seed = 5});
  const auto plain = calibrate(example::kr210(), c.data);
  const auto tukey = calibrate(example::kr210(), c.data, {.loss = Loss::Tukey});
  ASSERT_TRUE(plain && tukey);
  EXPECT_TRUE(tukey->rejected.empty());
  EXPECT_NEAR(example::mean_miss(tukey->cell, c), example::mean_miss(plain->cell, c), 1e-6);
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

TEST(Noise, APointThatIsLessSteadyThanItsNoiseCountsForLess) {
  const MeasurementNoise noise{.tracker = {.range_mm = 0.003, .transverse_mm = 0.003}};
  const Measurement points[] = {{.p_WS_mm = {2000, 0, 0}}, {.p_WS_mm = {2000, 0, 0}, .excess_mm = 0.004}};
  const Whitening whitening = whitening_of(points, noise);
  EXPECT_NEAR((whitening.W[0] * Eigen::Vector3d(0, 0.003, 0)).norm(), 0.003, 1e-12);
  EXPECT_NEAR((whitening.W[1] * Eigen::Vector3d(0, 0.005, 0)).norm(), 0.003, 1e-12);
}

TEST(Prior, StaysAwayWhereThePosesExciteTheArm) {
  const SimulatedCampaign c = example::campaign(example::true_arm(), 40, 30, {.seed = 7});
  const auto result = calibrate(example::kr210(), c.data);
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->prior_used);
  for (const IdentifiedParameter& p : result->parameters)
    EXPECT_EQ(p.data_share, p.identified ? 1 : 0) << p.name;
}

TEST(Deviations, OfAHeavyArmAreFoundDownToItsRepeatability) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SimulatedCampaign c =
        example::campaign(example::true_arm(heavy_arm_errors({.seed = seed})), 100, 60, {.seed = seed});
    const auto result = calibrate(example::kr210(), c.data, {.non_geometric = true});
    sum += example::mean_miss(result, c);
    EXPECT_GT(example::mean_miss(result->geometric, c), 0.2);
    EXPECT_TRUE(result->converged);
  }
  RecordProperty("mean_mm", std::to_string(sum / 5));
  EXPECT_LT(sum / 5, 0.035);
}

TEST(ResidualFields, ExplainWhatAGeometricModelLeaves) {
  const SimulatedCampaign c =
      example::campaign(example::true_arm(heavy_arm_errors({.seed = 3})), 100, 60, {.seed = 3});
  const auto result = calibrate(example::kr210(), c.data, {.field = FieldUse::Always});
  ASSERT_TRUE(result);
  ASSERT_TRUE(result->cell.robot.field);
  EXPECT_LT(example::mean_miss(result->cell, c), 0.7 * example::mean_miss(result->geometric, c));
  EXPECT_LT(result->validate->after.mean, result->validate->geometric.mean);
}

}  // namespace
}  // namespace truepose
