#include "core/change/movement.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/calibrate/calibrate.hpp"
#include "core/math/units.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/trials.hpp"

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
    EXPECT_EQ(moved->what, (Change{ChangeKind::Base, station}));
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

TEST(Tolerance, IsAskedOfWhatWasMeasuredAgainWhereItWas) {
  const MeasurementData data = moved_at(0, kStationPoses);
  const auto made = calibrate(example::kr210(), data, {.noise = kStationNoise});
  ASSERT_TRUE(made) << made.error().detail;
  CalibrationEvidence evidence{
      .calibration = *made, .data = data, .stated = kStationNoise, .tolerance_mm = 0.5};
  EXPECT_LT(calibration_verdict(evidence).findings.front().severity, Severity::Error);
  evidence.remeasured = made->identify.after;
  evidence.remeasured->max = 0.7;
  EXPECT_EQ(calibration_verdict(evidence).findings.front().sentence,
            "the largest error is 0.700 mm, beyond the tolerance of 0.500 mm");
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
    return finding.severity == Severity::Error &&
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

TEST(MovementAlongASweep, IsReportedWhereTheTrackerMoved) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random{seed};
    MeasurementData data = swept_along_joint_1(0, random);
    for (std::size_t i = 20; i < data.points.size(); ++i)
      data.points[i].p_WS_mm += Eigen::Vector3d(0.2, 0, 0.1);
    EXPECT_TRUE(is_said_to_have_moved(data)) << "seed " << seed;
  }
}

/// Poses of an arm in the order in which they were measured.
MeasurementData sixty_poses(Random& random) {
  return example::measured(example::placed(example::with_paper_errors(example::kr210()), random), 60,
                           example::kSigma_mm, random);
}

struct Judged {
  std::optional<Movement> movement;
  CalibrationVerdict verdict;
  bool warmth_kept = false;
};

/// As a user has it who states the noise and asks for nothing else.
Judged judged(MeasurementData data) {
  split_poses(data, 0.7, 1);
  const auto made = calibrate(example::kr210(), data, {.noise = kStationNoise});
  if (!made) {
    ADD_FAILURE() << made.error().detail;
    return {};
  }
  const MeasurementData there = as_fitted(*made, data);
  return {.movement = movement(made->cell, there.points, kStationNoise),
          .verdict = calibration_verdict({.calibration = *made, .data = there, .stated = kStationNoise}),
          .warmth_kept = made->thermal && made->thermal->response};
}

bool says(const CalibrationVerdict& verdict, std::string_view words) {
  return std::ranges::any_of(verdict.findings,
                             [=](const Finding& finding) { return finding.sentence.contains(words); });
}

bool advises(const CalibrationVerdict& verdict, std::string_view words) {
  return std::ranges::any_of(verdict.findings,
                             [=](const Finding& finding) { return finding.what_to_do.contains(words); });
}

TEST(TrackerMovedTwice, IsReportedWithBothMoments) {
  const Eigen::Vector3d away(0.8, 0, 0.6), elsewhere(-0.6, 0.8, 0);
  const std::uint64_t seeds = all_trials() ? 4 : 1;
  for (const double moved_mm : {0.2, 1.0, 3.0}) {
    if (moved_mm == 1.0 && !all_trials()) continue;
    for (const Eigen::Vector3d& then : {Eigen::Vector3d{0, 0, 0}, elsewhere}) {
      for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        Random random{seed};
        MeasurementData data = sixty_poses(random);
        for (std::size_t i = 20; i < 40; ++i) data.points[i].p_WS_mm += moved_mm * away;
        for (std::size_t i = 40; i < 60; ++i) data.points[i].p_WS_mm += moved_mm * then;
        const Judged is = judged(data);
        EXPECT_EQ(is.verdict.color(), VerdictColor::Red) << moved_mm << " mm, seed " << seed;
        EXPECT_TRUE(says(is.verdict, "the tracker or the base moved")) << moved_mm << " mm, seed " << seed;
        ASSERT_TRUE(is.movement);
        EXPECT_EQ(is.movement->before, 20) << moved_mm << " mm, seed " << seed;
        EXPECT_EQ(is.movement->before_again, 40) << moved_mm << " mm, seed " << seed;
      }
    }
  }
}

TEST(Movement, IsSoughtInTheOrderOfTheTimes) {
  Random random{11};
  MeasurementData data = sixty_poses(random);
  for (std::size_t i = 0; i < data.points.size(); ++i) data.points[i].time = std::to_string(30 * i);
  for (std::size_t i = 25; i < data.points.size(); ++i)
    data.points[i].p_WS_mm += Eigen::Vector3d(0.8, 0, 0.6);
  std::ranges::sort(data.points, {}, [](const Measurement& point) { return point.q[0]; });
  const Judged is = judged(data);
  ASSERT_TRUE(is.movement);
  EXPECT_EQ(is.movement->before, 25);
  EXPECT_EQ(data.points[is.movement->first].time, "750");
  EXPECT_TRUE(says(is.verdict, "between the points 25 and 26 that were measured"));
}

TEST(Movement, IsSoughtWhereAFileHasOneReflectorAfterTheOther) {
  Random random{13};
  CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  truth.reflectors.push_back({"2", {-60, 90, 110}});
  MeasurementData data = example::measured(truth, 40, example::kSigma_mm, random);
  ASSERT_EQ(data.points.size(), 80u);
  for (std::size_t i = 50; i < 80; ++i) data.points[i].p_WS_mm += Eigen::Vector3d(0.24, 0, 0.18);
  std::ranges::stable_sort(data.points, {}, &Measurement::smr);
  const Judged is = judged(data);
  ASSERT_TRUE(is.movement);
  EXPECT_EQ(is.movement->before, 50);
  EXPECT_EQ(is.verdict.color(), VerdictColor::Red);
}

TEST(SlippedJoint, IsNamedAndNotTakenForWarmth) {
  for (const int joint : {1, 2, 3, 4}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      Random random{seed};
      MeasurementData data = sixty_poses(random);
      for (std::size_t i = 0; i < 30; ++i) data.points[i].q[joint] -= 0.02 * kRadPerDeg;
      const Judged is = judged(data);
      EXPECT_FALSE(is.warmth_kept) << "joint " << joint + 1 << ", seed " << seed;
      ASSERT_TRUE(is.movement) << "joint " << joint + 1 << ", seed " << seed;
      EXPECT_EQ(is.movement->what, (Change{ChangeKind::JointZero, joint})) << "seed " << seed;
      EXPECT_TRUE(says(is.verdict, "the encoder offset of joint " + std::to_string(joint + 1) + " changed"));
      EXPECT_TRUE(is.verdict.failed()) << "joint " << joint + 1 << ", seed " << seed;
    }
  }
}

TEST(ExchangedReflector, IsNamed) {
  const std::uint64_t seeds = all_trials() ? 10 : 3;
  for (const double longer_mm : {0.5, 2.0}) {
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      Random random{seed};
      const CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
      CalibratedCell other = truth;
      other.reflectors[0].p_FS_mm += longer_mm * Eigen::Vector3d(0, 0.6, 0.8);
      MeasurementData data = example::measured(truth, 30, example::kSigma_mm, random);
      const MeasurementData then = example::measured(other, 30, example::kSigma_mm, random);
      data.points.insert(data.points.end(), then.points.begin(), then.points.end());
      const Judged is = judged(data);
      ASSERT_TRUE(is.movement) << longer_mm << " mm, seed " << seed;
      EXPECT_EQ(is.movement->what, (Change{ChangeKind::Reflector, 0})) << longer_mm << " mm, seed " << seed;
      EXPECT_EQ(is.movement->first, 30u) << longer_mm << " mm, seed " << seed;
      EXPECT_TRUE(is.verdict.failed());
      EXPECT_FALSE(advises(is.verdict, "--non-geometric")) << "seed " << seed;
    }
  }
}

TEST(ArmThatWarmsUpSlowly, IsNotPassedForAWarmOne) {
  int doubted = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Random random{seed};
    MeasurementData data = sixty_poses(random);
    JointVector at_last(6);
    for (double& zero : at_last) zero = 0.02 * kRadPerDeg * random.normal();
    for (std::size_t i = 0; i < data.points.size(); ++i)
      data.points[i].q -= std::expm1(-static_cast<double>(i) / 150) * at_last;
    const Judged is = judged(data);
    EXPECT_NE(is.verdict.color(), VerdictColor::Green) << "seed " << seed;
    doubted += says(is.verdict, "still warming up") ? 1 : 0;
  }
  EXPECT_GE(doubted, 5);
}

TEST(Reading, ThatIsGivenTwiceIsDoubted) {
  Random random{3};
  MeasurementData data = sixty_poses(random);
  EXPECT_EQ(judged(data).verdict.color(), VerdictColor::Green);
  const std::vector<Measurement> again = data.points;
  data.points.insert(data.points.end(), again.begin(), again.end());
  EXPECT_TRUE(says(judged(data).verdict, "60 points repeat the joints and the reading of others"));
}

TEST(ValidationPose, ThatWasComeBackToIsNotUnseen) {
  Random random{5};
  const CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  MeasurementData data = example::measured(truth, 20, example::kSigma_mm, random);
  for (Measurement point : std::vector(data.points)) {
    for (double& q : point.q) q += 0.002 * kRadPerDeg * random.normal();
    point.p_WS_mm += example::kSigma_mm * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    point.set = PoseSet::Validate;
    data.points.push_back(point);
  }
  const auto made = calibrate(example::kr210(), data, {.noise = kStationNoise});
  ASSERT_TRUE(made) << made.error().detail;
  EXPECT_TRUE(says(calibration_verdict({.calibration = *made, .data = data, .stated = kStationNoise}),
                   "nothing but the points that it was fitted to"));
}

TEST(ModelThatLeavesFarMoreThanNoise, IsNotGreen) {
  Random random{9};
  const CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random);
  MeasurementData data = example::measured(truth, 60, example::kSigma_mm, random);
  for (Measurement& point : data.points)
    for (double& q : point.q) q -= 0.02 * kRadPerDeg * std::sin(q);
  const Judged is = judged(data);
  EXPECT_EQ(is.verdict.color(), VerdictColor::Amber);
  EXPECT_TRUE(advises(is.verdict, "--non-geometric"));
}

}  // namespace
}  // namespace truepose
