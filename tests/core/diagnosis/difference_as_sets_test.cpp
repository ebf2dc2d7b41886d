#include "core/diagnosis/difference_as_sets.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/math/random.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

constexpr double kNoise_mm = 0.02;

/// Points of an arm that stands anywhere, each with the joints of another row.
std::vector<Measurement> in_another_order(const RobotModel& robot, int poses, Random& random) {
  const CalibratedCell truth = example::placed(robot, random);
  std::vector<Measurement> rows = example::measured(truth, poses, kNoise_mm, random).points;
  const std::vector<Measurement> made = rows;
  std::vector<std::size_t> order(rows.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  for (std::size_t k = order.size(); k-- > 1;)
    std::swap(order[k], order[static_cast<std::size_t>(random.uniform(0, static_cast<double>(k + 1)))]);
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k].p_WS_mm = made[order[k]].p_WS_mm;
  return rows;
}

TEST(DifferenceAsSets, IsTheNoiseForTheRightArmInAnyOrderAnywhere) {
  Random random{1};
  for (int trial = 0; trial < 20; ++trial) {
    const auto rows = in_another_order(example::kr210(), 60, random);
    EXPECT_LT(difference_as_sets(example::kr210(), 1, rows), kNoise_mm) << "trial " << trial;
  }
}

TEST(DifferenceAsSets, IsLargerForAnArmOneOfWhoseJointsTurnsTheOtherWay) {
  Random random{2};
  RobotModel wrong = example::kr210();
  wrong.joints[2].sign *= -1;
  for (int trial = 0; trial < 20; ++trial) {
    const auto rows = in_another_order(example::kr210(), 60, random);
    EXPECT_GT(difference_as_sets(wrong, 1, rows), 100 * kNoise_mm) << "trial " << trial;
  }
}

}  // namespace
}  // namespace truepose
