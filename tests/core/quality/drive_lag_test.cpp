#include "core/quality/drive_lag.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/core/lagging_drives.hpp"

namespace truepose {
namespace {

constexpr double kLagPeriod_s = 0.02;
constexpr int kLagSamples = 300;

double swung_axis(double t) { return 0.4 * (1 - std::cos(2.5 * t)) - 0.2 * (1 - std::cos(6 * t)); }
double axis_correction(double t) { return 0.01 * std::sin(1.3 * t); }

/// Three axes: with dead time and lag, with another lag, and one that stands.
std::vector<AxisSample> lagging_samples(double dead_time_s, double lag_s, double second_lag_s) {
  const auto first = lagging_axis([](double t) { return swung_axis(t) + axis_correction(t); }, dead_time_s,
                                  lag_s, kLagPeriod_s, kLagSamples),
             second = lagging_axis([](double t) { return -swung_axis(t); }, dead_time_s, second_lag_s,
                                   kLagPeriod_s, kLagSamples);
  std::vector<AxisSample> samples;
  for (int i = 0; i < kLagSamples; ++i) {
    const double t = i * kLagPeriod_s;
    const auto k = static_cast<std::size_t>(i);
    samples.push_back({t, Eigen::Vector3d{swung_axis(t), -swung_axis(t), 0.3},
                       Eigen::Vector3d{axis_correction(t), 0, 0}, Eigen::Vector3d{first[k], second[k], 0.3}});
  }
  return samples;
}

TEST(DriveLag, IsIdentifiedOfEachAxisFromWhatItWasGivenAndWhereItWas) {
  const DriveLag lag = identify_drive_lag(lagging_samples(0.012, 0.04, 0.025));
  ASSERT_EQ(lag.axes.size(), 3U);
  EXPECT_TRUE(lag.axes[0].identified);
  EXPECT_NEAR(lag.axes[0].dead_time_s, 0.012, 0.0005);
  EXPECT_NEAR(lag.axes[0].time_constant_s, 0.04, 0.0005);
  EXPECT_NEAR(lag.axes[1].dead_time_s, 0.012, 0.0005);
  EXPECT_NEAR(lag.axes[1].time_constant_s, 0.025, 0.0005);
  EXPECT_NEAR(lag.mean_delay_s(), 0.0445, 0.0005);
  EXPECT_LT(lag.residual_rad, 1e-5);
}

TEST(DriveLag, OfAnAxisThatStandsIsTheMeanOfTheOthers) {
  const DriveLag lag = identify_drive_lag(lagging_samples(0.012, 0.04, 0.02));
  EXPECT_FALSE(lag.axes[2].identified);
  EXPECT_NEAR(lag.axes[2].time_constant_s, 0.03, 0.0005);
}

TEST(DriveLag, IsNothingWhereTheAxesFollowAtOnceOrNoneMoves) {
  for (const AxisLag& axis : identify_drive_lag(lagging_samples(0, 0, 0)).axes)
    EXPECT_LT(axis.delay_s(), 0.0005);
  const std::vector<AxisSample> standing(
      5, AxisSample{1, Eigen::Vector2d{1, 2}, Eigen::Vector2d{0, 0}, Eigen::Vector2d{1, 2}});
  const DriveLag lag = identify_drive_lag(standing);
  ASSERT_EQ(lag.axes.size(), 2U);
  EXPECT_FALSE(lag.axes[0].identified);
  EXPECT_EQ(lag.mean_delay_s(), 0);
  EXPECT_TRUE(identify_drive_lag({}).axes.empty());
}

TEST(DriveLag, AppliedToTheSetPointsSaysWhereTheAxesWouldBeWithoutACorrection) {
  const std::vector<AxisSample> samples = lagging_samples(0.012, 0.04, 0.025);
  const std::vector<double> wanted = lagging_axis(swung_axis, 0.012, 0.04, kLagPeriod_s, kLagSamples);
  const std::vector<JointVector> lagged = lagged_set_points(samples, identify_drive_lag(samples));
  ASSERT_EQ(lagged.size(), samples.size());
  for (std::size_t i = 0; i < lagged.size(); ++i)
    EXPECT_NEAR(lagged[i][0], wanted[i], 2e-5) << "sample " << i;
}

TEST(DriveLag, BeginsAgainWhereTimeIsMissing) {
  std::vector<AxisSample> samples = lagging_samples(0.012, 0.04, 0.025);
  for (std::size_t i = 150; i < samples.size(); ++i) samples[i].time_s += 60;
  const DriveLag lag = identify_drive_lag(samples);
  const std::vector<JointVector> lagged = lagged_set_points(samples, lag);
  EXPECT_EQ(lagged[150][1], samples[150].actual[1]) << "where the axis is";
  EXPECT_NEAR(lag.axes[0].delay_s(), 0.052, 0.001);
}

}  // namespace
}  // namespace truepose
