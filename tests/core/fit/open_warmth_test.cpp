// Points of which nothing says when they were measured, of an arm that warmed up.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/math/angles.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "core/simulate/true_arm.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"

namespace truepose {
namespace {

constexpr MeasurementNoise kReadingsOfWarmth{.tracker = {.range_mm = 0.015, .transverse_mm = 0.015},
                                             .repeatability_mm = 0.0166};

/// A campaign that began with a cold arm, every third of its points put aside to validate.
MeasurementData warming_campaign(std::uint64_t seed) {
  Random random{seed};
  TrueArmSetup truth = example::true_arm();
  truth.warm_up = {.zero = JointVector(6), .growth = 30e-6, .time_constant = Seconds{35 * 60}};
  for (double& zero : truth.warm_up.zero) zero = 0.008 * kRadPerDeg * random.normal();
  TrueArm arm{truth, seed};
  MeasurementData data{.smr_names = {"1"}, .points = {}, .stations = {}};
  for (int n = 0; n < 120; ++n) {
    arm.warm_up(Seconds{60.0 * n});
    Measurement point{.q = random_poses(example::kr210(), 1, random).front()};
    arm.move_to(point.q);
    point.p_WS_mm = noisy_reading(arm.p_WS_mm(point.q), kReadingsOfWarmth.tracker, random);
    point.set = n % 3 == 1 ? PoseSet::Validate : PoseSet::Identify;
    point.in_order = point.set == PoseSet::Identify;
    data.points.push_back(point);
  }
  return data;
}

/// The points that validate after all others, as of a file of their own.
MeasurementData in_two_files(MeasurementData data) {
  std::ranges::stable_sort(data.points, {}, &Measurement::set);
  return data;
}

struct JudgedWarmth {
  Calibration calibration;
  CalibrationVerdict verdict;
};

JudgedWarmth judged_warmth(const MeasurementData& data) {
  auto made = calibrate(example::kr210(), data, {.noise = kReadingsOfWarmth, .check_model = false});
  EXPECT_TRUE(made) << made.error().detail;
  const MeasurementData fitted = as_fitted(*made, data);
  CalibrationVerdict verdict =
      calibration_verdict({.calibration = *made, .data = fitted, .stated = kReadingsOfWarmth});
  return {*std::move(made), std::move(verdict)};
}

TEST(PointsThatValidate, GiveTheSameFiguresInOneFileAndInTwo) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const MeasurementData data = warming_campaign(seed);
    const JudgedWarmth one = judged_warmth(data), two = judged_warmth(in_two_files(data));
    EXPECT_NEAR(one.calibration.validate->after.mean, two.calibration.validate->after.mean, 1e-9) << seed;
    EXPECT_NEAR(one.calibration.validate->after.max, two.calibration.validate->after.max, 1e-9) << seed;
    EXPECT_EQ(one.verdict.color(), two.verdict.color()) << seed;
    EXPECT_EQ(one.verdict.failed(), two.verdict.failed()) << seed;
  }
}

TEST(PointsThatValidate, AreJudgedByAnArmAsWarmAsTheirReadingsSayAndAreNotFlattered) {
  double mean_mm = 0;
  int warm = 0;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const JudgedWarmth made = judged_warmth(in_two_files(warming_campaign(seed)));
    EXPECT_FALSE(made.verdict.failed()) << seed << ": " << made.verdict.findings.front().sentence;
    const auto& thermal = made.calibration.thermal;
    if (!thermal || !thermal->response) continue;
    ++warm;
    mean_mm += made.calibration.validate->after.mean;
    EXPECT_TRUE(std::ranges::any_of(made.verdict.findings,
                                    [](const Finding& finding) { return finding.code == "V_WARMTH_OPEN"; }));
  }
  ASSERT_GE(warm, 6);
  // What a reading's noise alone makes: sqrt(8 / pi) of a coordinate's.
  const double by_noise_mm =
      1.596 * std::hypot(kReadingsOfWarmth.tracker.range_mm, kReadingsOfWarmth.repeatability_mm);
  EXPECT_GT(mean_mm / warm, 0.9 * by_noise_mm);
  EXPECT_LT(mean_mm / warm, 1.3 * by_noise_mm);
}

}  // namespace
}  // namespace truepose
