// One pose, measured again and again: whether it stayed where it was.
#include "core/change/reference_pose.hpp"

#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <vector>

#include "core/change/drift_causes.hpp"
#include "core/simulate/true_arm.hpp"

namespace truepose {
namespace {

constexpr KnownNoise kStated{
    .noise = {.tracker = {.range_mm = 0.01, .transverse_mm_per_m = 0.003}, .repeatability_mm = 0.0166},
    .degrees = 70};
constexpr double kAccuracy_mm = 0.05;

/// Five readings some hundredths of a millimetre apart; those from `moved` on, counted from 0, by so much
/// more.
std::vector<Eigen::Vector3d> readings(std::size_t moved, double way_mm) {
  std::vector<Eigen::Vector3d> all{{3000, 2000, 1000},
                                   {3000.012, 2000.01, 999.985},
                                   {2999.99, 2000.015, 1000.01},
                                   {3000.005, 1999.99, 1000},
                                   {2999.994, 2000.008, 1000.005}};
  for (std::size_t i = moved; i < all.size(); ++i) all[i] += way_mm * Eigen::Vector3d(0.6, 0, 0.8);
  return all;
}

TEST(ReferencePose, StaysWhereItIsAsFarAsNoiseTells) {
  EXPECT_FALSE(moved_reference(readings(0, 0), kStated, kAccuracy_mm));
}

TEST(ReferencePose, MovedByTwoTenthsBeforeAnyOfItsReadings) {
  for (std::size_t moved = 1; moved < 5; ++moved) {
    const auto sentence = moved_reference(readings(moved, 0.2), kStated, kAccuracy_mm);
    ASSERT_TRUE(sentence) << "before reading " << moved + 1;
    EXPECT_TRUE(sentence->sentence.contains("between its measurements " + std::to_string(moved) + " and " +
                                            std::to_string(moved + 1)))
        << sentence->sentence;
  }
}

TEST(ReferencePose, MayMoveByLessThanMattersToTheModel) {
  EXPECT_TRUE(moved_reference(readings(4, 0.2), kStated, 0.05));
  EXPECT_FALSE(moved_reference(readings(4, 0.2), kStated, 0.2));
}

/// Of how many of `runs` poses whose readings scatter by the noise, and step by `way_mm` before a random
/// one of them, it is said that they moved.
int said_to_have_moved(int runs, int count, double way_mm, const KnownNoise& noise) {
  const std::uint64_t seed = 7;
  Random random{seed};
  int said = 0;
  for (int run = 0; run < runs; ++run) {
    const auto moved = 1 + static_cast<int>(random.next() % static_cast<std::uint64_t>(count - 1));
    std::vector<Eigen::Vector3d> all;
    for (int i = 0; i < count; ++i) {
      Eigen::Vector3d p_mm{800, 300, 200};
      for (double& coordinate : p_mm) coordinate += noise.noise.repeatability_mm * random.normal();
      if (i >= moved) p_mm.z() += way_mm;
      all.push_back(noisy_reading(p_mm, noise.noise.tracker, random));
    }
    said += moved_reference(all, noise, 0).has_value();
  }
  std::cout << "seed " << seed << ": " << count << " readings, moved by " << way_mm << " mm: " << said
            << " of " << runs << '\n';
  return said;
}

TEST(ReferencePose, ThatStaysIsSaidToHaveMovedAtTheStatedLevel) {
  constexpr int kRuns = 20000;
  const KnownNoise exact{.noise = kStated.noise, .degrees = 1e6};
  for (const int count : {2, 5, 12}) {
    const int said = said_to_have_moved(kRuns, count, 0, exact);
    EXPECT_LE(said, kSignificance * kRuns + 30);  // three of its standard deviations
    EXPECT_GE(said, kSignificance * kRuns / 2);
  }
}

TEST(ReferencePose, ShowsAStepBySixTimesTheNoise) {
  EXPECT_GE(said_to_have_moved(1000, 5, 0.1, kStated), 850);
  EXPECT_EQ(said_to_have_moved(1000, 5, 0.2, kStated), 1000);
}

TEST(ReferencePose, StaysAsFarAsANoiseShowsThatIsHardlyKnown) {
  EXPECT_TRUE(moved_reference(readings(2, 0.1), kStated, kAccuracy_mm));
  EXPECT_FALSE(moved_reference(readings(2, 0.1), {.noise = kStated.noise, .degrees = 1}, kAccuracy_mm));
}

}  // namespace
}  // namespace truepose
