// Every method of regression, the product's and those of the literature.
#include "tools/experiment/regression_methods.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <map>
#include <string>

#include "core/field/field_choice.hpp"
#include "core/math/random.hpp"
#include "tests/allocations.hpp"
#include "tests/core/regression_sample.hpp"

namespace truepose {
namespace {

class EveryRegressor : public ::testing::TestWithParam<const RegressionMethod*> {};
INSTANTIATE_TEST_SUITE_P(Regression, EveryRegressor, ::testing::ValuesIn(kRegressionMethods),
                         [](const auto& test) { return std::string{test.param->name}; });

TEST_P(EveryRegressor, LeavesLittleOfASmoothField) {
  const std::map<const RegressionMethod*, double> at_most{{&kGaussianProcess, 0.08},
                                                          {&kKriging, 0.25},
                                                          {&kInverseDistance, 0.4},
                                                          {&kMovingLeastSquares, 0.35},
                                                          {&kNeuralNetwork, 0.12}};
  const RegressorPtr fitted = fit(*GetParam(), sample(150, 0.01, 1));
  EXPECT_LT(part_left(*fitted, sample(300, 0, 2)), at_most.at(GetParam()));
}

TEST_P(EveryRegressor, IsZeroFarFromTheData) {
  const RegressorPtr fitted = fit(*GetParam(), sample(80, 0.01, 3));
  Random random{4};
  for (int i = 0; i < 20; ++i) {
    Eigen::VectorXd direction(kFeatures);
    for (double& x : direction) x = random.normal();
    EXPECT_LT(predict(*fitted, 100 * direction.normalized()).norm(), 1e-6);
    // On the way out it stays in the order of what was measured.
    for (double distance = 0; distance < 10; distance += 0.25)
      EXPECT_LT(predict(*fitted, distance * direction.normalized()).norm(), 1.5);
  }
}

TEST_P(EveryRegressor, PredictsWithoutAllocating) {
  const RegressionData fresh = sample(50, 0, 5);
  const RegressorPtr fitted = fit(*GetParam(), sample(80, 0.01, 6));
  Eigen::VectorXd y(kTargets), x(kFeatures);
  const auto before = allocations();
  if (!before) GTEST_SKIP() << "a sanitizer has taken malloc for itself";
  for (Eigen::Index i = 0; i < fresh.X.rows(); ++i) {
    x = fresh.X.row(i);
    fitted->predict(x, y);
  }
  EXPECT_EQ(allocations(), before);
}

TEST_P(EveryRegressor, PredictsWithoutAllocatingOfTheMostFeatures) {
  RegressionData data = sample(120, 0.01, 30);
  Random random{31};
  data.X = Eigen::MatrixXd::NullaryExpr(120, kMaxFeatures, [&] { return random.uniform(-1.5, 1.5); });
  const RegressorPtr fitted = fit(*GetParam(), data);
  Eigen::VectorXd y(kTargets), x = data.X.row(0);
  const auto before = allocations();
  if (!before) GTEST_SKIP() << "a sanitizer has taken malloc for itself";
  fitted->predict(x, y);
  EXPECT_EQ(allocations(), before);
}

TEST_P(EveryRegressor, IsTheSameForTheSameData) {
  const RegressionData data = sample(60, 0.01, 9);
  EXPECT_EQ(predict(*fit(*GetParam(), data), data.X.row(0)), predict(*fit(*GetParam(), data), data.X.row(0)));
}

TEST_P(EveryRegressor, DoesNotMindTheUnitsOfFeaturesAndTargets) {
  const RegressionData data = sample(60, 0.01, 10);
  RegressionData other = data;
  other.X.col(1) = 1000 * data.X.col(1).array() + 5e4;
  other.Y *= 1e-3;
  Eigen::VectorXd x = sample(1, 0, 11).X.row(0), other_x = x;
  other_x[1] = 1000 * x[1] + 5e4;
  const Eigen::VectorXd expected = predict(*fit(*GetParam(), data), x);
  EXPECT_LT((1e3 * predict(*fit(*GetParam(), other), other_x) - expected).norm(), 1e-3 * expected.norm());
}

TEST_P(EveryRegressor, TakesWhatAnArmMayGiveIt) {
  RegressionData data = sample(30, 0.01, 12);
  data.X.col(2).setConstant(7);                // a joint that was never moved
  data.X.bottomRows(10) = data.X.topRows(10);  // poses measured twice
  data.Y.col(1).setZero();
  const RegressorPtr fitted = fit(*GetParam(), data);
  EXPECT_TRUE(predict(*fitted, data.X.row(0)).allFinite());
  EXPECT_NEAR(predict(*fitted, data.X.row(0))[1], 0, 1e-9);

  data.Y.setZero();
  EXPECT_EQ(predict(*fit(*GetParam(), data), data.X.row(0)).norm(), 0);
}

TEST_P(EveryRegressor, RefitKeepsTheHyperParameters) {
  const Hyper before = fit(*GetParam(), sample(60, 0.01, 13))->state().hyper;
  const RegressorPtr refitted = GetParam()->refit(before, sample(40, 0.01, 14));
  EXPECT_EQ(refitted->state().hyper, before);
  EXPECT_EQ(refitted->state().X.rows(), 40);
}

TEST(Kriging, IsLessCertainFarFromTheData) {
  const RegressorPtr fitted = fit(kKriging, sample(100, 0.01, 22));
  const Eigen::VectorXd near = Eigen::VectorXd::Zero(kFeatures),
                        far = Eigen::VectorXd::Constant(kFeatures, 30);
  EXPECT_LT(fitted->variance(near).maxCoeff(), 0.7 * fitted->variance(far).minCoeff());
}

TEST(MovingLeastSquares, MovesWithoutAJumpWherePointsReplaceEachOther) {
  const RegressorPtr fitted = fit(kMovingLeastSquares, sample(300, 0.05, 32));
  constexpr double kStep = 1e-4;
  const Eigen::VectorXd from = Eigen::VectorXd::Constant(kFeatures, -0.5),
                        along = Eigen::VectorXd::Constant(kFeatures, kStep);
  Eigen::VectorXd before = predict(*fitted, from);
  for (int i = 1; i < 5000; ++i) {
    const Eigen::VectorXd now = predict(*fitted, from + i * along);
    ASSERT_LT((now - before).norm(), 3 * kStep) << "step " << i;
    before = now;
  }
}

TEST(CrossValidation, LeavesPointsOfAGroupOutTogether) {
  // Every pose twice, with a target of its own: only its twin can tell.
  RegressionData data = sample(40, 1, 24, false);
  data.X.bottomRows(20) = data.X.topRows(20);
  data.Y.bottomRows(20) = data.Y.topRows(20);
  const auto apart = cross_validate(kInverseDistance, data);
  ASSERT_TRUE(apart) << apart.error();
  for (int i = 0; i < 40; ++i) data.groups.push_back(i % 20);
  const auto together = cross_validate(kInverseDistance, data);
  ASSERT_TRUE(together) << together.error();
  EXPECT_LT(apart->rms, 0.8);
  EXPECT_GT(together->rms, 1.2);
  EXPECT_EQ(together->squared_errors.size(), 20u);
}

TEST(CrossValidation, PredictsTheErrorAtFreshPoints) {
  const RegressionData data = sample(60, 0.02, 25), fresh = sample(400, 0.02, 26);
  for (const RegressionMethod* method : {&kGaussianProcess, &kMovingLeastSquares}) {
    const auto validated = cross_validate(*method, data);
    ASSERT_TRUE(validated) << validated.error();
    const double rms = part_left(*fit(*method, data), fresh) * std::sqrt(fresh.Y.squaredNorm() / 400);
    EXPECT_NEAR(validated->rms, rms, 4 * validated->standard_error) << method->name;
  }
}

TEST(CrossValidation, SaysWhatItsFitsExpected) {
  const RegressionData data = sample(60, 0.02, 28);
  const auto by_evidence = cross_validate(kGaussianProcess, data);
  const auto by_nothing = cross_validate(kInverseDistance, data);
  ASSERT_TRUE(by_evidence && by_nothing);
  EXPECT_NEAR(by_evidence->expected_rms, by_evidence->rms, 0.3 * by_evidence->rms);
  // A method that knows nothing of itself expects the targets whole.
  EXPECT_NEAR(by_nothing->expected_rms, std::sqrt(data.Y.squaredNorm() / 60), 0.05 * by_nothing->rms);
}

}  // namespace
}  // namespace truepose
