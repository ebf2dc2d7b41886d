#include "core/simulate/tracker_instrument.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace truepose {
namespace {

using namespace std::chrono_literals;

const Eigen::Vector3d kPoint_mm{3000, -1500, 400};

TEST(TrackerWarming, ErrsAsStatedAtFirstAndByAThirdOfThatAfterItsTime) {
  const TrackerWarming cold{.range_mm = 0.3, .minutes = 20};
  const double distance_mm = kPoint_mm.norm();
  EXPECT_NEAR(cold.seen(kPoint_mm, 0s).norm() - distance_mm, 0.3, 1e-9);
  EXPECT_NEAR(cold.seen(kPoint_mm, 20min).norm() - distance_mm, 0.3 / std::exp(1), 1e-9);
  EXPECT_NEAR(cold.seen(kPoint_mm, 24h).norm() - distance_mm, 0, 1e-9);
}

TEST(TrackerWarming, TurnsDirectionsAndKeepsDistances) {
  const TrackerWarming cold{.horizontal_rad = 20e-6, .vertical_rad = -15e-6};
  const Eigen::Vector3d seen_mm = cold.seen(kPoint_mm, 0s);
  EXPECT_NEAR(seen_mm.norm(), kPoint_mm.norm(), 1e-9);
  EXPECT_NEAR(std::atan2(seen_mm.y(), seen_mm.x()) - std::atan2(kPoint_mm.y(), kPoint_mm.x()), 20e-6, 1e-12);
  EXPECT_NEAR(std::asin(seen_mm.z() / seen_mm.norm()) - std::asin(kPoint_mm.z() / kPoint_mm.norm()), 15e-6,
              1e-12);
}

TEST(TripodDrift, MovesAllThatIsSeenInProportionToTime) {
  const TripodDrift loose{.mm_per_hour = {0.2, 0, -0.1}, .rad_per_hour = {0, 0, 50e-6}};
  EXPECT_EQ(loose.moved(kPoint_mm, 0s), kPoint_mm);
  const Eigen::Vector3d by_mm = loose.moved(kPoint_mm, 30min) - kPoint_mm;
  const Eigen::Vector3d expected_mm =
      Eigen::Vector3d{0.1, 0, -0.05} + Eigen::Vector3d{0, 0, 25e-6}.cross(kPoint_mm);
  EXPECT_LT((by_mm - expected_mm).norm(), 1e-5);
}

}  // namespace
}  // namespace truepose
