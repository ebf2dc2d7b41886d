#include <gmock/gmock.h>

#include <Eigen/Core>
#include <cmath>
#include <string>

#include "core/field/field_choice.hpp"
#include "core/field/gaussian_process.hpp"
#include "tests/core/regression_sample.hpp"

namespace truepose {
namespace {

using ::testing::HasSubstr;

TEST(Regression, RefusesDataThatCannotBeFitted) {
  const auto error_of = [](const RegressionData& data) {
    const auto fitted = fit_regressor(kGaussianProcess, data);
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
}

TEST(GaussianProcess, RecoversASmoothFieldFreeOfNoise) {
  const RegressorPtr fitted = fit(kGaussianProcess, sample(150, 0, 16));
  EXPECT_LT(part_left(*fitted, sample(200, 0, 17)), 0.02);
}

TEST(GaussianProcess, TakesNoiseForNoise) {
  const RegressorPtr fitted = fit(kGaussianProcess, sample(100, 0.02, 18, false));
  EXPECT_LT(part_left(*fitted, sample(200, 0.02, 19, false)), 1.02);
}

TEST(GaussianProcess, KnowsHowWrongItMayBe) {
  const RegressorPtr fitted = fit(kGaussianProcess, sample(60, 0.01, 20));
  const RegressionData fresh = sample(500, 0, 21);
  double squares = 0;
  for (Eigen::Index i = 0; i < fresh.X.rows(); ++i) {
    const Eigen::VectorXd error = fresh.Y.row(i).transpose() - predict(*fitted, fresh.X.row(i));
    squares += (error.array().square() / fitted->variance(fresh.X.row(i).transpose()).array()).mean();
  }
  EXPECT_NEAR(std::sqrt(squares / 500), 1, 0.35);
}

TEST(GaussianProcess, RestoredFromItsStatePredictsTheSameToTheLastBit) {
  const RegressionData fresh = sample(50, 0, 7);
  const RegressorPtr fitted = fit(kGaussianProcess, sample(60, 0.01, 8));
  const auto restored = restore_gaussian_process(fitted->state());
  ASSERT_TRUE(restored) << restored.error();
  for (Eigen::Index i = 0; i < fresh.X.rows(); ++i)
    EXPECT_EQ(predict(**restored, fresh.X.row(i)), predict(*fitted, fresh.X.row(i)));
}

TEST(GaussianProcess, RefusesAStateThatLacksAHyperParameter) {
  RegressorState state = fit(kGaussianProcess, sample(20, 0.01, 15))->state();
  const std::string name = state.hyper.begin()->first;
  state.hyper.erase(name);
  const auto restored = restore_gaussian_process(state);
  ASSERT_FALSE(restored);
  EXPECT_THAT(restored.error(), HasSubstr(name));
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

TEST(CrossValidation, RefusesASingleGroup) {
  RegressionData data = sample(10, 0.1, 27);
  data.groups.assign(10, 3);
  EXPECT_FALSE(cross_validate(kGaussianProcess, data));
}

TEST(FieldChoice, IsNoneOnNoiseUnlessAskedFor) {
  for (std::uint64_t seed = 100; seed < 103; ++seed) {
    const RegressionData noise = sample(25, 0.02, seed, false);
    const auto choice = choose_field(noise, FieldUse::Auto), asked = choose_field(noise, FieldUse::Always);
    ASSERT_TRUE(choice && asked);
    EXPECT_FALSE(choice->chosen || choice->regressor) << "seed " << seed;
    EXPECT_TRUE(asked->chosen && asked->regressor);
    EXPECT_EQ(asked->tried.rms, choice->tried.rms);
  }
}

TEST(FieldChoice, IsTheProcessOnASmoothFieldAndSaysWhatItBought) {
  const auto choice = choose_field(sample(50, 0.01, 28), FieldUse::Auto);
  ASSERT_TRUE(choice) << choice.error();
  ASSERT_TRUE(choice->chosen);
  EXPECT_LT(choice->tried.rms, choice->rms_zero);
  EXPECT_LT(part_left(*choice->regressor, sample(300, 0, 29)), 0.3);
}

}  // namespace
}  // namespace truepose
