#include "core/quality/path_accuracy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <vector>

namespace truepose {
namespace {

using Eigen::Vector3d;

constexpr double kPeriod_s = 0.02;

/// A sample with all of the correction, at the k-th time.
PathSample sample_at(int k, const Vector3d& wanted_mm, const Vector3d& with_mm, const Vector3d& without_mm) {
  return {.time_s = k * kPeriod_s,
          .gain_percent = 100,
          .wanted_mm = wanted_mm,
          .with_mm = with_mm,
          .without_mm = without_mm};
}

PathSample point_at(int k, double with_mm, double without_mm, double gain_percent = 100) {
  const Vector3d wanted{100.0 * k, 0, 0};
  PathSample point =
      sample_at(k, wanted, wanted + Vector3d{0, 0, with_mm}, wanted + Vector3d{without_mm, 0, 0});
  point.at_point = true;
  point.gain_percent = gain_percent;
  return point;
}

TEST(PathAccuracy, OfPointsIsTheDistanceFromTheWantedPositionWhereAllOfTheCorrectionWasInForce) {
  std::vector<PathSample> samples;
  for (int k = 1; k <= 20; ++k) samples.push_back(point_at(k, 0.1 * k, k));
  samples.push_back(point_at(21, 50, 50, 99));
  samples.push_back(point_at(22, 50, 50, -1));
  const PathAccuracy accuracy = path_accuracy(samples);
  ASSERT_TRUE(accuracy.points);
  EXPECT_EQ(accuracy.points->count, 20);
  EXPECT_EQ(accuracy.points_partly_corrected, 2);
  EXPECT_NEAR(accuracy.points->with.mean, 1.05, 1e-12);
  EXPECT_NEAR(accuracy.points->with.p95, 1.9, 1e-12);
  EXPECT_NEAR(accuracy.points->with.max, 2, 1e-12);
  EXPECT_NEAR(accuracy.points->without.mean, 10.5, 1e-12);
  EXPECT_NEAR(accuracy.points->without.p95, 19, 1e-12);
  EXPECT_NEAR(accuracy.points->without.max, 20, 1e-12);
  EXPECT_FALSE(accuracy.path);
  EXPECT_FALSE(accuracy.refuted());
}

TEST(PathAccuracy, TakesNoTimeOfTheDrivesForAnError) {
  // Along x at 1 m/s, 60 mm behind and 0.3 mm off the path; without the correction 2 mm off it.
  std::vector<PathSample> samples;
  for (int k = 0; k < 100; ++k) {
    const double x = 20.0 * k;
    samples.push_back(sample_at(k, {x, 0, 0}, {x - 60, 0.3, 0}, {x, 0, 2}));
  }
  samples.erase(samples.begin(), samples.begin() + 10);
  for (int k = 0; k < 10; ++k) samples[static_cast<std::size_t>(k)].gain_percent = 50;
  const PathAccuracy accuracy = path_accuracy(samples);
  ASSERT_TRUE(accuracy.path);
  EXPECT_EQ(accuracy.path->count, 80);
  EXPECT_NEAR(accuracy.path->with.mean, 0.3, 1e-9);
  EXPECT_NEAR(accuracy.path->with.max, 0.3, 1e-9);
  EXPECT_NEAR(accuracy.path->without.mean, 2, 1e-9);
  EXPECT_FALSE(accuracy.points);
}

TEST(PathAccuracy, TakesNoChordOfACircleForThePath) {
  // A radius of 50 mm at 0.5 m/s, whose chords are 0.25 mm away from it; lagging by half a sample.
  const auto on_circle = [](double radius_mm, double angle) {
    return Vector3d{radius_mm * std::cos(angle), radius_mm * std::sin(angle), 0};
  };
  std::vector<PathSample> samples;
  for (int k = 0; k < 40; ++k) {
    const double angle = 0.2 * k;
    samples.push_back(
        sample_at(k, on_circle(50, angle), on_circle(50.04, angle - 0.1), on_circle(49, angle)));
  }
  // Beside the first and the last chord.
  samples[0].gain_percent = samples[1].gain_percent = samples.back().gain_percent = 0;
  const PathAccuracy accuracy = path_accuracy(samples);
  EXPECT_NEAR(accuracy.path->with.max, 0.04, 0.003);
  EXPECT_NEAR(accuracy.path->without.max, 1, 0.003);
}

/// Samples 10 mm apart: out along y = 0 to x = 590 mm, and back along y = 5 where the arm is still at y = 1.
std::vector<PathSample> out_and_back(double pause_s) {
  std::vector<PathSample> samples;
  for (int k = 0; k < 120; ++k) {
    const bool back = k >= 60;
    const double x = 10.0 * (back ? 119 - k : k);
    samples.push_back(back ? sample_at(k, {x, 5, 0}, {x, 1, 0}, {x, 5, 0})
                           : sample_at(k, {x, 0, 0}, {x, 0, 0}, {x, 0, 0}));
    if (back) samples.back().time_s += pause_s;
  }
  return samples;
}

TEST(PathAccuracy, LooksForThePathNoFartherThanHalfASecondOfMotion) {
  std::vector<PathSample> samples = out_and_back(0);
  for (PathSample& sample : std::span{samples}.first(73)) sample.gain_percent = 0;
  // Sample 72 and the one out at the same place are 25 samples apart; by then it is the path out that is
  // nearer.
  EXPECT_NEAR(path_accuracy(samples).path->with.max, 4, 1e-9);
  samples[72].gain_percent = 100;
  EXPECT_NEAR(path_accuracy(samples).path->with.mean, (47 * 4 + 1) / 48.0, 1e-9);
}

TEST(PathAccuracy, LooksForThePathNotAcrossAPause) {
  std::vector<PathSample> samples = out_and_back(2);
  for (PathSample& sample : std::span{samples}.first(60)) sample.gain_percent = 0;
  EXPECT_NEAR(path_accuracy(samples).path->with.mean, 4, 1e-9);
}

TEST(PathAccuracy, CountsNoErrorAlongThePathWhereTheArmStandsForLong) {
  std::vector<PathSample> samples;
  for (int k = 0; k < 200; ++k) {
    const double x = k < 50 ? 5.0 * k : k < 150 ? 250 : 250 + 5.0 * (k - 150);
    samples.push_back(sample_at(k, {x, 0, 0}, {x + 0.8, 0.1, 0}, {x + 0.8, 0.1, 0}));
  }
  samples.back().gain_percent = 0;
  EXPECT_NEAR(path_accuracy(samples).path->with.max, 0.1, 1e-9);
}

TEST(PathAccuracy, CountsNoPointAsPartlyCorrectedWhereTheProgramWaitsForTheCorrection) {
  std::vector<PathSample> samples{point_at(1, 1, 1, 0), point_at(1, 1, 1, 60), point_at(2, 1, 1)};
  EXPECT_EQ(path_accuracy(samples).points_partly_corrected, 2) << "it goes on at 60 %";
  samples[1].gain_percent = 100;
  EXPECT_EQ(path_accuracy(samples).points_partly_corrected, 0);
  samples.push_back(point_at(3, 1, 1, 60));
  EXPECT_EQ(path_accuracy(samples).points_partly_corrected, 1) << "it ends there";
}

TEST(PathAccuracy, IsRefutedByThePointsAndByThePathWhereThereAreNone) {
  std::vector<PathSample> samples{point_at(1, 2, 1)};
  EXPECT_TRUE(path_accuracy(samples).refuted());
  samples[0].gain_percent = -2;
  EXPECT_FALSE(path_accuracy(samples).refuted()) << "nothing is judged";
  samples.push_back(sample_at(2, {0, 0, 0}, {0, 2, 0}, {0, 1, 0}));
  EXPECT_TRUE(path_accuracy(samples).refuted());
  samples.push_back(point_at(3, 1, 2));
  EXPECT_FALSE(path_accuracy(samples).refuted());
}

}  // namespace
}  // namespace truepose
