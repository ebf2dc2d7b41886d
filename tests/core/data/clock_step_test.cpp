#include "core/data/clock_step.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/calibrate/calibrate.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

constexpr double kEvery_s = 40;

std::vector<Measurement> one_after_another(int count) {
  std::vector<Measurement> points(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    points[static_cast<std::size_t>(i)].time = std::to_string(1e6 + kEvery_s * i);
  return points;
}

void put_forward(Measurement& point, double seconds) {
  point.time = std::to_string(std::stod(point.time) + seconds);
}

TEST(ClockStep, IsWhereTheTimesGoBackAndRunOnFromThere) {
  for (const double by : {-3600.0, -600.0}) {
    std::vector<Measurement> points = one_after_another(60);
    for (std::size_t i = 31; i < points.size(); ++i) put_forward(points[i], by);
    const auto step = clock_step(points);
    ASSERT_TRUE(step) << by;
    EXPECT_EQ(step->before, 30u);
    EXPECT_EQ(step->after, 31u);
    EXPECT_NEAR(step->back_s, -by - kEvery_s, 1e-3);
  }
}

TEST(ClockStep, IsNotOneOfPointsInTheOrderOfTheirTimes) {
  std::vector<Measurement> points = one_after_another(60);
  EXPECT_FALSE(clock_step(points));
  for (std::size_t i = 31; i < points.size(); ++i) put_forward(points[i], 3600);
  EXPECT_FALSE(clock_step(points)) << "a break";
  for (Measurement& point : points) point.time = "2026-11-26T08:00:00";
  EXPECT_FALSE(clock_step(points)) << "a clock that stands";
}

TEST(ClockStep, IsNotOneOfAPointThatWasMeasuredAgain) {
  std::vector<Measurement> points = one_after_another(60);
  for (const std::size_t i : {10u, 40u}) put_forward(points[i], 5000);
  EXPECT_FALSE(clock_step(points));
}

TEST(ClockStep, IsNotOneOfRowsThatStandInAnotherOrder) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Random random{seed};
    std::vector<Measurement> points = one_after_another(20);
    for (std::size_t i = points.size() - 1; i > 0; --i) std::swap(points[i], points[random.next() % (i + 1)]);
    EXPECT_FALSE(clock_step(points)) << "seed " << seed;
  }
}

TEST(ClockStep, IsNotOneWhereAReflectorOrTheValidationStandsBehindTheOther) {
  std::vector<Measurement> points = one_after_another(60);
  const auto odd_ones_last = [&](auto set) {
    std::vector<Measurement> all;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (i % 2 == 0) all.push_back(points[i]);
    for (std::size_t i = 1; i < points.size(); i += 2) set(all.emplace_back(points[i]));
    return all;
  };
  EXPECT_FALSE(clock_step(odd_ones_last([](Measurement& point) { point.smr = 1; })));
  EXPECT_FALSE(clock_step(odd_ones_last([](Measurement& point) { point.set = PoseSet::Validate; })));
}

TEST(ClockThatWasSetBack, LeavesNoModelGreen) {
  Random random{8};
  const CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  MeasurementData data = example::measured(truth, 60, example::kSigma_mm, random);
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    data.points[i].time = std::to_string(1e6 + kEvery_s * static_cast<double>(i));
    data.points[i].row = static_cast<int>(i) + 1;
  }
  split_poses(data, 0.7, 1);
  const MeasurementNoise noise{.repeatability_mm = example::kSigma_mm};
  const auto color_of = [&] {
    const auto made = calibrate(example::kr210(), data, {.noise = noise});
    EXPECT_TRUE(made);
    return calibration_verdict({.calibration = *made, .data = data, .stated = noise}).color();
  };
  EXPECT_EQ(color_of(), VerdictColor::Green);
  for (std::size_t i = 30; i < data.points.size(); ++i) put_forward(data.points[i], -3600);
  EXPECT_EQ(color_of(), VerdictColor::Amber);
}

}  // namespace
}  // namespace truepose
