#include "core/judge/movement.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/identify/calibrate.hpp"
#include "core/judge/calibration_verdict.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

constexpr MeasurementNoise kStationNoise{.repeatability_mm = example::kSigma_mm};
constexpr std::size_t kStationPoses = 30;  // from each of two stations

/// Two stations, of which the points of one are moved from the point of this number of its own on.
MeasurementData moved_at(int station, std::size_t moment) {
  Random random{71};
  const CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  CalibratedCell elsewhere = truth;
  elsewhere.base = example::placed(example::kr210(), random).base;
  MeasurementData data = example::measured(truth, kStationPoses, example::kSigma_mm, random);
  data.stations = {"monday"};
  MeasurementData door = example::measured(elsewhere, kStationPoses, example::kSigma_mm, random);
  door.stations = {"door"};
  add_station(data, door);
  for (std::size_t i = moment; i < kStationPoses; ++i)
    data.points[static_cast<std::size_t>(station) * kStationPoses + i].p_WS_mm +=
        Eigen::Vector3d(0.2, 0, 0.1);
  return data;
}

TEST(MovementBetweenStations, IsSoughtFromEachOfThemAndTellsOfIt) {
  for (const int station : {0, 1}) {
    const MeasurementData data = moved_at(station, 20);
    const auto made = calibrate(example::kr210(), data, {.noise = kStationNoise});
    ASSERT_TRUE(made) << made.error().detail;
    const auto moved = movement(made->cell, data.points, kStationNoise);
    ASSERT_TRUE(moved);
    EXPECT_EQ(moved->station, station);
    EXPECT_EQ(moved->first, static_cast<std::size_t>(station) * kStationPoses + 20);
    EXPECT_NEAR(moved->moved_mm, 0.22, 0.05);
    const CalibrationVerdict verdict =
        calibration_verdict({.calibration = *made, .data = data, .stated = kStationNoise});
    const std::string begin = std::string("station '") + (station == 0 ? "monday" : "door") +
                              "': the tracker or the base moved by about 0.2";
    EXPECT_TRUE(verdict.findings.front().sentence.starts_with(begin)) << verdict.findings.front().sentence;
    EXPECT_TRUE(verdict.findings.front().sentence.contains("between the points 20 and 21"));
  }
}

TEST(MovementBetweenStations, IsNoneWhereEachStoodStill) {
  const MeasurementData data = moved_at(0, kStationPoses);
  const auto made = calibrate(example::kr210(), data, {.noise = kStationNoise});
  ASSERT_TRUE(made) << made.error().detail;
  EXPECT_FALSE(movement(made->cell, data.points, kStationNoise));
}

/// An arm with a gear of joint 1 so far out of round, measured in the order of that joint.
MeasurementData swept_along_joint_1(double eccentric_rad, Random& random) {
  const CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  MeasurementData data = example::measured(truth, 40, example::kSigma_mm, random);
  const double phase = random.uniform(0, 6.28);
  for (Measurement& point : data.points) point.q[0] -= eccentric_rad * std::sin(point.q[0] + phase);
  std::ranges::sort(data.points, {}, [](const Measurement& point) { return point.q[0]; });
  return data;
}

/// Whether the verdict on it, without deviations, says that tracker or base moved.
bool is_said_to_have_moved(const MeasurementData& data) {
  const auto made = calibrate(example::kr210(), data, {.noise = kStationNoise});
  if (!made) return false;
  const CalibrationVerdict verdict =
      calibration_verdict({.calibration = *made, .data = data, .stated = kStationNoise});
  return std::ranges::any_of(verdict.findings, [](const Finding& finding) {
    return finding.severity == Severity::Refusal &&
           finding.sentence.starts_with("the tracker or the base moved");
  });
}

TEST(MovementAlongASweep, IsNotWhatAJointErrsWithItsAngle) {
  for (const double eccentric_rad : {0.05e-3, 0.2e-3, 1e-3}) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      Random random{seed};
      EXPECT_FALSE(is_said_to_have_moved(swept_along_joint_1(eccentric_rad, random)))
          << 1e3 * eccentric_rad << " mrad, seed " << seed;
    }
  }
}

TEST(MovementAlongASweep, IsToldWhereTheTrackerMoved) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random{seed};
    MeasurementData data = swept_along_joint_1(0, random);
    for (std::size_t i = 20; i < data.points.size(); ++i)
      data.points[i].p_WS_mm += Eigen::Vector3d(0.2, 0, 0.1);
    EXPECT_TRUE(is_said_to_have_moved(data)) << "seed " << seed;
  }
}

}  // namespace
}  // namespace truepose
