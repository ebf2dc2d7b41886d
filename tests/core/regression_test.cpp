#include <gmock/gmock.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/field/gaussian_process.hpp"
#include "core/field/regressor.hpp"
#include "core/field/select_regressor.hpp"
#include "core/math/random.hpp"
#include "tests/allocations.hpp"

namespace truepose {
namespace {

using ::testing::HasSubstr;

constexpr int kFeatures = 4, kTargets = 3;

/// A smooth field of the size of a robot's residuals, mm.
Eigen::Vector3d field(const Eigen::VectorXd& x) {
  return 0.2 * Eigen::Vector3d{std::sin(1.5 * x[0]) + 0.5 * x[1] * std::cos(x[2]),
                               std::cos(1.5 * x[1]) * std::sin(x[0]), std::sin(x[0] + x[1])};
}

/// N points of the field, or of zero, with noise.
RegressionData sample(int N, double noise, std::uint64_t seed, bool with_field = true) {
  Random random{seed};
  RegressionData data{Eigen::MatrixXd(N, kFeatures), Eigen::MatrixXd::Zero(N, kTargets), {}};
  for (int i = 0; i < N; ++i) {
    for (double& x : data.X.row(i)) x = random.uniform(-1.5, 1.5);
    if (with_field) data.Y.row(i) = field(data.X.row(i).transpose());
    for (double& y : data.Y.row(i)) y += noise * random.normal();
  }
  return data;
}

RegressorPtr fit(RegressorKind kind, const RegressionData& data) {
  const auto fitted = fit_regressor(kind, data);
  EXPECT_TRUE(fitted) << (fitted ? "" : fitted.error());
  return fitted.value_or(nullptr);
}

Eigen::VectorXd predict(const Regressor& regressor, const Eigen::VectorXd& x) {
  Eigen::VectorXd y(kTargets);
  regressor.predict(x, y);
  return y;
}

/// rms of what is left of the targets, over their rms.
double part_left(const Regressor& regressor, const RegressionData& fresh) {
  double left = 0;
  for (Eigen::Index i = 0; i < fresh.X.rows(); ++i)
    left += (fresh.Y.row(i).transpose() - predict(regressor, fresh.X.row(i))).squaredNorm();
  return std::sqrt(left / fresh.Y.squaredNorm());
}

class EveryRegressor : public ::testing::TestWithParam<RegressorKind> {};
INSTANTIATE_TEST_SUITE_P(Regression, EveryRegressor, ::testing::ValuesIn(kAllRegressors),
                         [](const auto& test) { return std::string{name_of(test.param)}; });

TEST_P(EveryRegressor, LeavesLittleOfASmoothField) {
  const std::map<RegressorKind, double> at_most{{RegressorKind::GaussianProcess, 0.08},
                                                {RegressorKind::Kriging, 0.25},
                                                {RegressorKind::InverseDistance, 0.4},
                                                {RegressorKind::MovingLeastSquares, 0.35},
                                                {RegressorKind::NeuralNetwork, 0.12}};
  const RegressorPtr fitted = fit(GetParam(), sample(150, 0.01, 1));
  EXPECT_LT(part_left(*fitted, sample(300, 0, 2)), at_most.at(GetParam()));
}

TEST_P(EveryRegressor, IsZeroFarFromTheData) {
  const RegressorPtr fitted = fit(GetParam(), sample(80, 0.01, 3));
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
  const RegressorPtr fitted = fit(GetParam(), sample(80, 0.01, 6));
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
  const RegressorPtr fitted = fit(GetParam(), data);
  Eigen::VectorXd y(kTargets), x = data.X.row(0);
  const auto before = allocations();
  if (!before) GTEST_SKIP() << "a sanitizer has taken malloc for itself";
  fitted->predict(x, y);
  EXPECT_EQ(allocations(), before);
}

TEST_P(EveryRegressor, RestoredFromItsStatePredictsTheSameToTheLastBit) {
  const RegressionData fresh = sample(50, 0, 7);
  const RegressorPtr fitted = fit(GetParam(), sample(60, 0.01, 8));
  const auto restored = restore_regressor(fitted->state());
  ASSERT_TRUE(restored) << restored.error();
  for (Eigen::Index i = 0; i < fresh.X.rows(); ++i)
    EXPECT_EQ(predict(**restored, fresh.X.row(i)), predict(*fitted, fresh.X.row(i)));
}

TEST_P(EveryRegressor, IsTheSameForTheSameData) {
  const RegressionData data = sample(60, 0.01, 9);
  EXPECT_EQ(predict(*fit(GetParam(), data), data.X.row(0)), predict(*fit(GetParam(), data), data.X.row(0)));
}

TEST_P(EveryRegressor, DoesNotMindTheUnitsOfFeaturesAndTargets) {
  const RegressionData data = sample(60, 0.01, 10);
  RegressionData other = data;
  other.X.col(1) = 1000 * data.X.col(1).array() + 5e4;
  other.Y *= 1e-3;
  Eigen::VectorXd x = sample(1, 0, 11).X.row(0), other_x = x;
  other_x[1] = 1000 * x[1] + 5e4;
  const Eigen::VectorXd expected = predict(*fit(GetParam(), data), x);
  EXPECT_LT((1e3 * predict(*fit(GetParam(), other), other_x) - expected).norm(), 1e-3 * expected.norm());
}

TEST_P(EveryRegressor, TakesWhatAnArmMayGiveIt) {
  RegressionData data = sample(30, 0.01, 12);
  data.X.col(2).setConstant(7);                // a joint that was never moved
  data.X.bottomRows(10) = data.X.topRows(10);  // poses measured twice
  data.Y.col(1).setZero();
  const RegressorPtr fitted = fit(GetParam(), data);
  EXPECT_TRUE(predict(*fitted, data.X.row(0)).allFinite());
  EXPECT_NEAR(predict(*fitted, data.X.row(0))[1], 0, 1e-9);

  data.Y.setZero();
  EXPECT_EQ(predict(*fit(GetParam(), data), data.X.row(0)).norm(), 0);
}

TEST_P(EveryRegressor, RefitKeepsTheHyperParameters) {
  const RegressorState before = fit(GetParam(), sample(60, 0.01, 13))->state();
  const auto refitted = refit_regressor(before, sample(40, 0.01, 14));
  ASSERT_TRUE(refitted) << refitted.error();
  EXPECT_EQ((*refitted)->state().hyper, before.hyper);
  EXPECT_EQ((*refitted)->state().X.rows(), 40);
}

TEST_P(EveryRegressor, RefusesAStateThatLacksAHyperParameter) {
  RegressorState state = fit(GetParam(), sample(20, 0.01, 15))->state();
  const std::string name = state.hyper.begin()->first;
  state.hyper.erase(name);
  const auto restored = restore_regressor(state);
  ASSERT_FALSE(restored);
  EXPECT_THAT(restored.error(), HasSubstr(name));
}

TEST_P(EveryRegressor, HasANameThatFindsItAgain) {
  EXPECT_EQ(regressor_kind(name_of(GetParam())), GetParam());
}

TEST(Regression, RefusesDataThatCannotBeFitted) {
  const auto error_of = [](const RegressionData& data) {
    const auto fitted = fit_regressor(RegressorKind::Kriging, data);
    return fitted ? std::string{} : fitted.error();
  };
  EXPECT_THAT(error_of(sample(3, 0, 0)), HasSubstr("needs 4 points"));
  RegressionData data = sample(10, 0, 0);
  data.Y(3, 1) = std::nan("");
  EXPECT_THAT(error_of(data), HasSubstr("finite"));
  data = sample(10, 0, 0);
  data.groups = {1, 2};
  EXPECT_THAT(error_of(data), HasSubstr("as many"));
  EXPECT_THAT(error_of({Eigen::MatrixXd::Zero(10, kMaxFeatures + 1), Eigen::MatrixXd::Zero(10, 1), {}}),
              HasSubstr("features"));
  EXPECT_EQ(regressor_kind("oracle"), std::nullopt);
}

TEST(GaussianProcess, RecoversASmoothFieldFreeOfNoise) {
  const RegressorPtr fitted = fit(RegressorKind::GaussianProcess, sample(150, 0, 16));
  EXPECT_LT(part_left(*fitted, sample(200, 0, 17)), 0.02);
}

TEST(GaussianProcess, TakesNoiseForNoise) {
  const RegressorPtr fitted = fit(RegressorKind::GaussianProcess, sample(100, 0.02, 18, false));
  EXPECT_LT(part_left(*fitted, sample(200, 0.02, 19, false)), 1.02);
}

TEST(GaussianProcess, KnowsHowWrongItMayBe) {
  const RegressorPtr fitted = fit(RegressorKind::GaussianProcess, sample(60, 0.01, 20));
  const RegressionData fresh = sample(500, 0, 21);
  double squares = 0;
  for (Eigen::Index i = 0; i < fresh.X.rows(); ++i) {
    const Eigen::VectorXd error = fresh.Y.row(i).transpose() - predict(*fitted, fresh.X.row(i));
    squares += (error.array().square() / fitted->variance(fresh.X.row(i).transpose()).array()).mean();
  }
  EXPECT_NEAR(std::sqrt(squares / 500), 1, 0.35);
}

TEST(Kriging, IsLessCertainFarFromTheData) {
  const RegressorPtr fitted = fit(RegressorKind::Kriging, sample(100, 0.01, 22));
  const Eigen::VectorXd near = Eigen::VectorXd::Zero(kFeatures),
                        far = Eigen::VectorXd::Constant(kFeatures, 30);
  EXPECT_LT(fitted->variance(near).maxCoeff(), 0.7 * fitted->variance(far).minCoeff());
}

TEST(MovingLeastSquares, MovesWithoutAJumpWherePointsReplaceEachOther) {
  const RegressorPtr fitted = fit(RegressorKind::MovingLeastSquares, sample(300, 0.05, 32));
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

TEST(MarginalLikelihood, HasTheGradientOfDifferences) {
  const RegressionData data = sample(40, 0.05, 23);
  for (const Correlation kind : {Correlation::SquaredExponential, Correlation::Matern52}) {
    const MarginalLikelihood likelihood{data.X, data.Y, kind};
    Eigen::VectorXd at(kFeatures + 1), gradient, unused;
    at << 0.3, -0.2, 0.8, 1.2, -1.5;
    likelihood(at, gradient);
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      const Eigen::VectorXd step = 1e-5 * Eigen::VectorXd::Unit(at.size(), k);
      const double difference = (likelihood(at + step, unused) - likelihood(at - step, unused)) / 2e-5;
      EXPECT_NEAR(gradient[k], difference, 1e-5 * (1 + std::abs(difference)));
    }
  }
}

std::expected<CrossValidation, std::string> cross_validated(RegressorKind kind, const RegressionData& data) {
  auto selection = select_regressor(data, {&kind, 1});
  if (!selection) return std::unexpected{selection.error()};
  return std::move(selection->tried.front());
}

TEST(CrossValidation, LeavesPointsOfAGroupOutTogether) {
  // Every pose twice, with a target of its own: only its twin can tell.
  RegressionData data = sample(40, 1, 24, false);
  data.X.bottomRows(20) = data.X.topRows(20);
  data.Y.bottomRows(20) = data.Y.topRows(20);
  const auto apart = cross_validated(RegressorKind::InverseDistance, data);
  ASSERT_TRUE(apart) << apart.error();
  for (int i = 0; i < 40; ++i) data.groups.push_back(i % 20);
  const auto together = cross_validated(RegressorKind::InverseDistance, data);
  ASSERT_TRUE(together) << together.error();
  EXPECT_LT(apart->rms, 0.8);
  EXPECT_GT(together->rms, 1.2);
  EXPECT_EQ(together->squared_errors.size(), 20u);
}

TEST(CrossValidation, PredictsTheErrorAtFreshPoints) {
  const RegressionData data = sample(60, 0.02, 25), fresh = sample(400, 0.02, 26);
  for (const RegressorKind kind : {RegressorKind::GaussianProcess, RegressorKind::MovingLeastSquares}) {
    const auto validated = cross_validated(kind, data);
    ASSERT_TRUE(validated) << validated.error();
    const double rms = part_left(*fit(kind, data), fresh) * std::sqrt(fresh.Y.squaredNorm() / 400);
    EXPECT_NEAR(validated->rms, rms, 4 * validated->standard_error) << name_of(kind);
  }
}

TEST(CrossValidation, SaysWhatItsFitsExpected) {
  const RegressionData data = sample(60, 0.02, 28);
  const auto by_evidence = cross_validated(RegressorKind::GaussianProcess, data);
  const auto by_nothing = cross_validated(RegressorKind::InverseDistance, data);
  ASSERT_TRUE(by_evidence && by_nothing);
  EXPECT_NEAR(by_evidence->expected_rms, by_evidence->rms, 0.3 * by_evidence->rms);
  // A method that knows nothing of itself expects the targets whole.
  EXPECT_NEAR(by_nothing->expected_rms, std::sqrt(data.Y.squaredNorm() / 60), 0.05 * by_nothing->rms);
}

TEST(CrossValidation, RefusesASingleGroup) {
  RegressionData data = sample(10, 0.1, 27);
  data.groups.assign(10, 3);
  EXPECT_FALSE(cross_validated(RegressorKind::GaussianProcess, data));
}

TEST(SelectRegressor, ChoosesNoneOnNoise) {
  for (std::uint64_t seed = 100; seed < 103; ++seed) {
    const auto selection = select_regressor(sample(25, 0.02, seed, false));
    ASSERT_TRUE(selection) << selection.error();
    EXPECT_EQ(selection->kind, std::nullopt) << "seed " << seed;
    EXPECT_EQ(selection->regressor, nullptr);
  }
}

TEST(SelectRegressor, ChoosesTheBestOnASmoothFieldAndSaysWhatEachBought) {
  const auto selection = select_regressor(sample(50, 0.01, 28));
  ASSERT_TRUE(selection) << selection.error();
  ASSERT_EQ(selection->tried.size(), kAllRegressors.size());
  const auto& best = *std::ranges::min_element(selection->tried, {}, &CrossValidation::rms);
  EXPECT_EQ(selection->kind, best.kind);
  for (const CrossValidation& tried : selection->tried)
    EXPECT_LT(tried.rms, selection->rms_zero) << name_of(tried.kind);
  EXPECT_LT(part_left(*selection->regressor, sample(300, 0, 29)), 0.3);
}

}  // namespace
}  // namespace truepose
