// One pose, measured again and again: whether it stayed where it was.
#include "core/judge/reference_pose.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace truepose {
namespace {

constexpr MeasurementNoise kStated{.tracker = {.range_mm = 0.01, .transverse_mm_per_m = 0.003},
                                   .repeatability_mm = 0.0166};
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
    const auto told = moved_reference(readings(moved, 0.2), kStated, kAccuracy_mm);
    ASSERT_TRUE(told) << "before reading " << moved + 1;
    EXPECT_TRUE(told->contains("between its measurements " + std::to_string(moved) + " and " +
                               std::to_string(moved + 1)))
        << *told;
  }
}

TEST(ReferencePose, MayMoveByLessThanMattersToTheModel) {
  EXPECT_TRUE(moved_reference(readings(4, 0.2), kStated, 0.05));
  EXPECT_FALSE(moved_reference(readings(4, 0.2), kStated, 0.2));
}

}  // namespace
}  // namespace truepose
