#include "core/change/tracker_motion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/math/random.hpp"
#include "core/simulate/true_arm.hpp"

namespace truepose {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr TrackerNoiseModel kMotionNoise{.range_mm = 0.005, .transverse_mm_per_m = 0.003};
const std::vector<Eigen::Vector3d> kNests_mm{
    {1500, -1400, -800}, {1800, 1500, -700}, {3200, -300, -1200}, {2500, 900, 600}};

Eigen::Isometry3d motion_of(const Eigen::Vector3d& shift_mm, const Eigen::Vector3d& turn_rad = {0, 0, 0}) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  if (turn_rad.norm() > 0)
    X.linear() = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()).toRotationMatrix();
  X.translation() = shift_mm;
  return X;
}

/// What a tracker sees that has so moved, that X brings back.
class Nests : public testing::Test {
 protected:
  NestReadings seen(const Eigen::Isometry3d& X = Eigen::Isometry3d::Identity(), bool noisy = true) {
    NestReadings readings;
    for (const Eigen::Vector3d& p_mm : nests_mm) {
      const Eigen::Vector3d now_mm = X.inverse() * p_mm;
      readings.push_back({noisy ? noisy_reading(now_mm, kMotionNoise, random) : now_mm, 1});
    }
    return readings;
  }
  void seed(std::uint64_t number) { random = Random{number}; }

  std::vector<Eigen::Vector3d> nests_mm = kNests_mm;
  Random random{1};
};

TEST_F(Nests, TellHowTheTrackerMoved) {
  const Eigen::Isometry3d X = motion_of({3, -2, 1}, {2e-3, -1e-3, 3e-3});
  const auto motion =
      tracker_motion(seen(motion_of({0, 0, 0}), false), seen(X, false), {.tracker = kMotionNoise});
  ASSERT_TRUE(motion) << motion.error();
  EXPECT_LT((motion->X.matrix() - X.matrix()).norm(), 1e-9);
  EXPECT_LT((motion->turn_rad() - Eigen::Vector3d(2e-3, -1e-3, 3e-3)).norm(), 1e-9);
  EXPECT_LT(motion->probability, 1e-12);
  EXPECT_NEAR(motion->fit, 1, 1e-6);
}

TEST_F(Nests, StateShiftAndTurnWithTheUncertaintyThatTheyHave) {
  constexpr int kTrials = 400;
  const Eigen::Isometry3d X = motion_of({0.02, 0.03, -0.01}, {5e-6, 0, -8e-6});
  double distance2 = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    seed(static_cast<std::uint64_t>(trial));
    const auto motion = tracker_motion(seen(), seen(X), {.tracker = kMotionNoise});
    Eigen::Matrix<double, 6, 1> off;
    off << motion->shift_mm() - (X * motion->centre_mm - motion->centre_mm),
        motion->turn_rad() - Eigen::Vector3d(5e-6, 0, -8e-6);
    distance2 += off.dot(motion->covariance.inverse() * off);
  }
  // The mean of so many chi-squares of 6 degrees of freedom scatters by sqrt(12 / trials).
  EXPECT_NEAR(distance2 / kTrials, 6, 4 * std::sqrt(12.0 / kTrials));
}

TEST_F(Nests, SeldomAccuseATrackerThatStandsStill) {
  int reported = 0;
  for (std::uint64_t trial = 0; trial < 1000; ++trial) {
    seed(trial);
    std::vector<NestReadings> checks;
    for (int check = 0; check < 7; ++check) checks.push_back(seen());
    const StandHistory history = stand_history(checks, kMotionNoise);
    reported += history.moved() || !history.doubts.empty();
  }
  EXPECT_LE(reported, 20) << "twice kSignificance: of moves, and of nests that disagree";
}

TEST_F(Nests, FindATripodThatSlippedByATwentiethOfAMillimetre) {
  const Eigen::Isometry3d X = motion_of({0.03, 0.04, 0});
  int found = 0;
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    seed(trial);
    const std::vector<NestReadings> checks{seen(), seen(), seen(X), seen(X), seen(X)};
    const StandHistory history = stand_history(checks, kMotionNoise);
    found += history.stands.size() == 2 && history.stands.back().first == 2;
  }
  EXPECT_GE(found, 190) << "of 200";
  seed(1);
  const std::vector<NestReadings> checks{seen(), seen(), seen(X), seen(X)};
  EXPECT_THAT(described_moves(stand_history(checks, kMotionNoise)),
              ElementsAre(HasSubstr("between measurements 2 and 3 of the nests the tracker moved")));
}

TEST_F(Nests, BringPointsBackToWhereTheFirstStandSawThem) {
  const Eigen::Isometry3d X = motion_of({0.3, 0.4, 0}, {2e-5, 0, 0});
  const std::vector<NestReadings> checks{seen(), seen(), seen(X), seen(X)};
  const StandHistory history = stand_history(checks, kMotionNoise);
  const Eigen::Vector3d p_mm{3000, 200, -300};
  EXPECT_EQ(history.to_start(0, 0.5).matrix(), Eigen::Matrix4d::Identity());
  EXPECT_LT((history.to_start(2, 0.5) * p_mm - X * p_mm).norm(), 0.03);
  EXPECT_LT((history.to_start(3, 0.9) * p_mm - X * p_mm).norm(), 0.03);
  const Eigen::Vector3d half_mm = (p_mm + X * p_mm) / 2;
  EXPECT_LT((history.to_start(1, 0.5) * p_mm - half_mm).norm(), 0.03) << "between the two it moved evenly";
  EXPECT_FALSE(history.stepped_after(0));
  EXPECT_TRUE(history.stepped_after(1));
  EXPECT_FALSE(history.stepped_after(2));
  EXPECT_FALSE(history.stepped_after(3));
}

TEST_F(Nests, FollowATripodThatDrifts) {
  std::vector<NestReadings> checks;
  for (int check = 0; check < 7; ++check) checks.push_back(seen(motion_of({0.04 * check, 0, 0})));
  const StandHistory history = stand_history(checks, kMotionNoise);
  for (int check = 0; check < 6; ++check) {
    const Eigen::Isometry3d X = history.to_start(static_cast<std::size_t>(check), 0.5);
    EXPECT_NEAR(X.translation().x(), 0.04 * (check + 0.5), 0.05) << check;
  }
  checks.clear();
  for (int check = 0; check < 7; ++check) checks.push_back(seen(motion_of({0.4 * check, 0, 0})));
  for (std::size_t check = 0; check < 6; ++check)
    EXPECT_FALSE(stand_history(checks, kMotionNoise).stepped_after(check)) << check;
}

TEST_F(Nests, OfWhichOneIsLooseNameItAndGoByTheOthers) {
  const NestReadings before = seen();
  nests_mm[2].z() += 0.4;
  const StandHistory history = stand_history(std::vector{before, seen(), seen()}, kMotionNoise);
  EXPECT_FALSE(history.moved());
  ASSERT_EQ(history.doubts.size(), 2U);
  EXPECT_THAT(history.doubts.front(), HasSubstr("measurement 2 of the nests: nest 3 moved by itself"));
}

TEST_F(Nests, OfWhichThreeAloneDisagreeSayNothing) {
  nests_mm.resize(3);
  const NestReadings before = seen();
  nests_mm[1] *= 1.0005;
  const StandHistory history = stand_history(std::vector{before, seen()}, kMotionNoise);
  EXPECT_FALSE(history.moved());
  ASSERT_EQ(history.doubts.size(), 1U);
  EXPECT_THAT(history.doubts.front(), HasSubstr("which one moved is not identifiable"));
}

TEST_F(Nests, ThatAreHiddenOnceAreMissedOnlyThen) {
  NestReadings some = seen(), few = seen();
  some[0].readings = 0;
  few[0].readings = few[1].readings = 0;
  const StandHistory history = stand_history(std::vector{seen(), some, few, seen()}, kMotionNoise);
  EXPECT_EQ(history.stands.size(), 1U);
  EXPECT_EQ(history.stands.front().last, 3U);
  EXPECT_THAT(history.doubts, ElementsAre(HasSubstr("measurement 3 of the nests: fewer than three")));
}

TEST_F(Nests, AreNotNeeded) {
  const StandHistory history = stand_history({}, kMotionNoise);
  EXPECT_FALSE(history.moved());
  EXPECT_THAT(described_moves(history), IsEmpty());
}

}  // namespace
}  // namespace truepose
