#include "core/change/change_hypothesis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/math/units.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose {
namespace {

TEST(HypothesisTable, HasOneRowForEachKindAndProfile) {
  for (const HypothesisRow& row : kHypotheses) {
    EXPECT_EQ(&row_of({{row.kind}, row.profile}), &row) << row.counted_by;
    EXPECT_GT(row.prior, 0);
    EXPECT_LE(row.prior, 1);
    EXPECT_LT(row.most_false_alarms, 0.05);
    EXPECT_FALSE(row.counted_by.empty());
  }
}

TEST(NameOfAChange, SaysWhatHappenedByHowMuchAndHowWellThatIsKnown) {
  Random random{1};
  const CalibratedCell cell = example::placed(example::kr210(), random);
  ChangeFound found{{{ChangeKind::JointZero, 2}}};
  found.moved = Eigen::VectorXd::Constant(1, 0.0123 * kRadPerDeg);
  found.sigma = Eigen::VectorXd::Constant(1, 0.0005 * kRadPerDeg);
  EXPECT_EQ(described(found, cell, {}), "axis 3's zero moved by 0.0123 deg");
  EXPECT_EQ(described_with_sigma(found, cell, {}), "axis 3's zero moved by 0.0123 deg (sigma 0.0005 deg)");
  found.profile = TimeProfile::Step;
  EXPECT_EQ(name_of(found, cell, {}), "the encoder offset of joint 3 changed");
}

/// 0.5 (w / (1 + w) c^2 - ln(1 + w)) with w = 4 * 9, c^2 = 6^2 / 9; for a scale that ten residuals state, of
/// 30 with squares 40, -(10 + 30) / 2 ln(1 - w / (1 + w) c^2 / 50) - 0.5 ln(1 + w).
TEST(ChangeEvidence, IsTheMarginalLikelihoodOverThatOfNoChange) {
  const Eigen::MatrixXd N = Eigen::MatrixXd::Constant(1, 1, 9);
  const Eigen::VectorXd b = Eigen::VectorXd::Constant(1, 6);
  const double taken = 36.0 / 37 * 4;
  EXPECT_NEAR(ChangeEvidence(N, b).at(2), 0.5 * (taken - std::log(37)), 1e-12);
  const ChangeEvidence unknown(N, b, {.stated = 10, .squares = 40, .degrees = 30});
  EXPECT_NEAR(unknown.at(2), -20 * std::log(1 - taken / 50) - 0.5 * std::log(37), 1e-12);
  EXPECT_NEAR(unknown.gain(), 4, 1e-12);
  EXPECT_NEAR(unknown.step()[0], 6.0 / 9, 1e-12);
  EXPECT_NEAR(unknown.sigma()[0], 1.0 / 3, 1e-12);
  EXPECT_GE(unknown.best(), unknown.at(2));
}

TEST(ChangeEvidence, OfColumnsThatTheParametersTakeUpIsNone) {
  const Eigen::MatrixXd rounding = Eigen::MatrixXd::Constant(1, 1, 1e-12);
  const ChangeEvidence none(rounding, Eigen::VectorXd::Constant(1, 1e-5), {}, 1);
  EXPECT_EQ(none.rank(), 0);
  EXPECT_EQ(none.best(), 0);
  EXPECT_EQ(none.chance(0), 1);
}

}  // namespace
}  // namespace truepose
