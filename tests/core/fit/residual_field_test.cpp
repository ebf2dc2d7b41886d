// What a residual field is made of.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/fit/regression_field.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

TEST(ResidualField, TurnsTheFlangeThoughOneReadingWasLeftOut) {
  Random random{3};
  const CalibratedCell cell = example::placed(example::kr210(), random, 3);
  MeasurementData data = example::measured(cell, 20, example::kSigma_mm, random);
  EXPECT_EQ(field_data(cell, data.points).regression.Y.cols(), 6);

  data.points.erase(data.points.begin() + 4);
  std::vector<Measurement> points;
  const std::vector<bool> makes = makes_field(data.points);
  for (std::size_t i = 0; i < data.points.size(); ++i)
    if (makes[i]) points.push_back(data.points[i]);
  EXPECT_EQ(points.size(), 19 * 3);
  EXPECT_EQ(field_data(cell, points).regression.Y.cols(), 6);
}

TEST(ResidualField, IsMadeOfAllPosesWhereManyHaveTooFewReadingsForATurn) {
  Random random{3};
  const CalibratedCell cell = example::placed(example::kr210(), random, 2);
  const MeasurementData data = example::measured(cell, 20, example::kSigma_mm, random);
  const std::vector<bool> makes = makes_field(data.points);
  EXPECT_EQ(std::ranges::count(makes, true), std::ssize(data.points));
}

TEST(ResidualField, IsMadeOfTwoThousandPosesOfMorePoses) {
  Random random{3};
  const CalibratedCell cell = example::placed(example::kr210(), random, 1);
  const MeasurementData data = example::measured(cell, 3000, example::kSigma_mm, random);
  const std::vector<bool> makes = makes_field(data.points);
  EXPECT_EQ(std::ranges::count(makes, true), std::ssize(makes) * 2 / 3);
  EXPECT_EQ(std::count(makes.begin(), makes.begin() + 300, true), 200) << "spread evenly";
}

}  // namespace
}  // namespace truepose
