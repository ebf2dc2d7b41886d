// How surely outliers are named, and how seldom good points are.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"
#include "tests/trials.hpp"

namespace truepose {
namespace {

constexpr MeasurementNoise kPointNoise{
    .tracker = {.range_mm = kTrackerNoise_mm, .transverse_mm = kTrackerNoise_mm},
    .repeatability_mm = kRepeatability_mm};

/// The numbers of `points`.
std::vector<std::size_t> numbers(const std::vector<RejectedPoint>& points) {
  std::vector<std::size_t> result;
  for (const RejectedPoint& point : points) result.push_back(point.point);
  return result;
}

/// A campaign of which some points of both sets are made outliers.
struct Contaminated {
  Contaminated(std::uint64_t seed, int identify, int validate, double fraction, double min_mm, double max_mm)
      : campaign{example::campaign(example::true_arm(), identify, validate, {.seed = seed})} {
    Random random{seed};
    for (const PoseSet set : {PoseSet::Identify, PoseSet::Validate}) {
      std::vector<std::size_t> of_set;
      for (std::size_t i = 0; i < campaign.data.points.size(); ++i)
        if (campaign.data.points[i].set == set) of_set.push_back(i);
      const auto wrong = static_cast<std::size_t>(std::lround(fraction * static_cast<double>(of_set.size())));
      for (std::size_t n = 0; n < std::max(wrong, std::size_t{1}); ++n) {
        std::swap(of_set[n], of_set[n + random.next() % (of_set.size() - n)]);
        Eigen::Vector3d way(random.normal(), random.normal(), random.normal());
        campaign.data.points[of_set[n]].p_WS_mm += random.uniform(min_mm, max_mm) * way.normalized();
        (set == PoseSet::Identify ? identified : validated).push_back(of_set[n]);
      }
    }
    std::ranges::sort(identified);
    std::ranges::sort(validated);
  }
  Calibration oracle(const CalibrateOptions& options) const {
    MeasurementData good = campaign.data;
    for (auto it = identified.rbegin(); it != identified.rend(); ++it)
      good.points.erase(good.points.begin() + static_cast<std::ptrdiff_t>(*it));
    return *calibrate(example::kr210(), good, options);
  }
  SimulatedCampaign campaign;
  std::vector<std::size_t> identified, validated;
};

/// How far the screened fit may be from one without the outliers.
constexpr double kAsGood = 1.005;

TEST(Screening, NamesGrossErrorsAndNoOthers) {
  for (const double fraction : {0.01, 0.04, 0.05}) {
    int right = 0;
    for (int seed = 1; seed <= trials(200); ++seed) {
      const Contaminated c(static_cast<std::uint64_t>(seed), 60, 30, fraction, 0.5, 50);
      CalibrateOptions options{.loss = Loss::Squared, .noise = kPointNoise, .check_model = false};
      const Calibration oracle = c.oracle(options);
      options.loss = Loss::OutlierRejection;
      const auto found = calibrate(example::kr210(), c.campaign.data, options);
      ASSERT_TRUE(found) << found.error().detail;
      right += numbers(found->rejected) == c.identified &&
               numbers(found->validation_outliers) == c.validated &&
               example::mean_miss(found->cell, c.campaign) <=
                   kAsGood * example::mean_miss(oracle.cell, c.campaign);
    }
    EXPECT_EQ(right, trials(200)) << fraction;
  }
}

TEST(Screening, NamesARowOfZerosAndOneBeyondAllWorlds) {
  for (const double length_mm : {0.0, 1e12}) {
    int right = 0;
    for (int seed = 1; seed <= trials(200); ++seed) {
      auto c = example::campaign(example::true_arm(), 30, 30, {.seed = static_cast<std::uint64_t>(seed)});
      const auto wrong = static_cast<std::size_t>(seed) % 30;
      c.data.points[wrong].p_WS_mm = length_mm * Eigen::Vector3d(0.6, 0, 0.8);
      const auto found = calibrate(example::kr210(), c.data, {.noise = kPointNoise, .check_model = false});
      right += found && numbers(found->rejected) == std::vector{wrong};
    }
    EXPECT_EQ(right, trials(200)) << length_mm << " mm";
  }
}

TEST(Screening, LeavesSoundPointsIn) {
  for (const bool stated : {true, false}) {
    for (const int poses : {12, 30, 100}) {
      int named = 0;
      for (int seed = 1; seed <= trials(200); ++seed) {
        const auto c =
            example::campaign(example::true_arm(), poses, 30, {.seed = static_cast<std::uint64_t>(seed)});
        CalibrateOptions options{.check_model = false};
        if (stated) options.noise = kPointNoise;
        const auto found = calibrate(example::kr210(), c.data, options);
        ASSERT_TRUE(found) << found.error().detail;
        named += !found->rejected.empty() || !found->validation_outliers.empty();
      }
      EXPECT_LE(named, 1) << poses << " poses";
    }
  }
}

}  // namespace
}  // namespace truepose
