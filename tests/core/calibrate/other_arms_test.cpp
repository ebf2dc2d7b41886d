#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/calibrate/calibrate.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/least_variance.hpp"

namespace truepose {
namespace {

struct Outcome {
  int rank = 0;
  double rmse_over_bound = 0;
};

/// Identifies arms that deviate from `nominal`, and judges them where the points truly are.
Outcome identified(const RobotModel& nominal, int reflectors, std::uint64_t seed) {
  // The ratio of so many scatters by 0.015.
  constexpr int kTrials = 200, kPoses = 40;
  Random random{seed};
  Outcome outcome;
  double squared = 0, bound = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const CalibratedCell truth =
        example::placed(example::deviating(nominal, random, 0.5, 1e-3), random, reflectors);
    MeasurementData data = example::measured(truth, kPoses, example::kSigma_mm, random);
    MeasurementData fresh = example::measured(truth, kPoses, 0, random);
    bound += least_variance(truth, data, fresh) / static_cast<double>(fresh.points.size());
    for (Measurement& point : fresh.points) {
      point.set = PoseSet::Validate;
      data.points.push_back(point);
    }
    const auto result = calibrate(nominal, data);
    EXPECT_TRUE(result) << result.error().detail;
    if (!result) return {};
    EXPECT_TRUE(trial == 0 || result->rank == outcome.rank);
    outcome.rank = result->rank;
    squared += result->validate->geometric.rms * result->validate->geometric.rms;
  }
  outcome.rmse_over_bound = std::sqrt(squared / bound);
  return outcome;
}

TEST(OtherArms, ASevenAxisArmIsIdentifiedAtTheStatisticalLimit) {
  const Outcome outcome = identified(example::seven_axis(), 1, 1);
  EXPECT_EQ(outcome.rank, 4 * 7 + 3);
  EXPECT_NEAR(outcome.rmse_over_bound, 1, 0.05);
}

TEST(OtherArms, AnArmOnARailIsIdentifiedAtTheStatisticalLimit) {
  const Outcome outcome = identified(example::kr210_on_a_rail(), 1, 2);
  EXPECT_EQ(outcome.rank, 2 + 4 * 6 + 3);
  EXPECT_NEAR(outcome.rmse_over_bound, 1, 0.05);
}

TEST(OtherArms, AnArmWithCoupledJointsIsIdentifiedAtTheStatisticalLimit) {
  const Outcome outcome = identified(example::lr_mate(), 1, 5);
  EXPECT_EQ(outcome.rank, 27);
  EXPECT_NEAR(outcome.rmse_over_bound, 1, 0.05);
}

TEST(OtherArms, AnArmWhoseFlangeIsAlwaysUprightIsIdentifiedAtTheStatisticalLimit) {
  const Outcome outcome = identified(example::scara(), 1, 5);
  EXPECT_EQ(outcome.rank, 17);
  EXPECT_NEAR(outcome.rmse_over_bound, 1, 0.05);
}

TEST(OtherArms, OfAnUprightFlangeTheReflectorsHeightIsKeptAndSaidOnce) {
  Random random{6};
  const CalibratedCell truth =
      example::placed(example::deviating(example::scara(), random, 0.5, 1e-3), random);
  const auto result = calibrate(example::scara(), example::measured(truth, 40, example::kSigma_mm, random));
  ASSERT_TRUE(result) << result.error().detail;
  EXPECT_LT(std::abs(result->cell.reflectors[0].p_FS_mm.z()), 1);
  const auto tells = [](const Combination& c) { return c.sentence.find("smr.1.z") != std::string::npos; };
  EXPECT_EQ(std::ranges::count_if(result->unknown, tells), 1);
}

TEST(OtherArms, ThreeReflectorsGiveTheOrientationOfTheToolToo) {
  const Outcome outcome = identified(example::kr210(), 3, 3);
  EXPECT_EQ(outcome.rank, 27 + 6);
  EXPECT_NEAR(outcome.rmse_over_bound, 1, 0.05);
}

TEST(OtherArms, AToolOfSeveralReflectorsIsFoundWhereEachPoseShowsOnlyOneOfThem) {
  Random random{4};
  const CalibratedCell truth = example::placed(example::with_paper_errors(example::kr210()), random, 3);
  MeasurementData data = example::measured(truth, 90, 0, random);
  std::erase_if(data.points, [](const Measurement& m) { return (m.row - 1) / 3 % 3 != m.smr; });
  const auto result = calibrate(example::kr210(), data);
  ASSERT_TRUE(result);
  const auto distance = [](const CalibratedCell& cell, std::size_t i, std::size_t j) {
    return (cell.reflectors[i].p_FS_mm - cell.reflectors[j].p_FS_mm).norm();
  };
  EXPECT_NEAR(distance(result->cell, 0, 1), distance(truth, 0, 1), 1e-6);
  EXPECT_NEAR(distance(result->cell, 1, 2), distance(truth, 1, 2), 1e-6);
}

}  // namespace
}  // namespace truepose
