#include "core/math/residual_distribution.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/math/random.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr int kPoints = 5, kCoordinates = 3 * kPoints;

/// Errors of so many points: normal ones, each point's divided by the root of a chi-square variable of four
/// degrees of freedom over four. Their mean square is twice that of the normal ones.
Eigen::VectorXd heavy_errors(int points, double sigma, Random& random) {
  Eigen::VectorXd r(3 * points);
  for (int n = 0; n < points; ++n) {
    double chi2 = 0;
    for (int k = 0; k < 4; ++k) chi2 += std::pow(random.normal(), 2);
    for (int k = 0; k < 3; ++k) r[3 * n + k] = sigma * random.normal() / std::sqrt(chi2 / 4);
  }
  return r;
}

std::vector<double> distances2(const Eigen::VectorXd& r) {
  std::vector<double> all;
  for (Eigen::Index row = 0; row < r.size(); row += 3) all.push_back(r.segment<3>(row).squaredNorm());
  return all;
}

TEST(ResidualDistribution, IsChiSquareWhereNothingWasValidated) {
  const Eigen::VectorXd r = Eigen::VectorXd::Constant(kCoordinates, 1.3);
  EXPECT_EQ(ResidualDistribution{}.tail(r, kCoordinates), chi_square_tail(r.squaredNorm(), kCoordinates));
}

TEST(ResidualDistribution, OfManyValidationPointsIsAsOftenExceededAsItSays) {
  constexpr int kTrials = 20'000;
  for (const double sigma : {0.5, 1.0, 3.0}) {
    Random random(20261124);
    const ResidualDistribution law(distances2(heavy_errors(2000, sigma, random)));
    int exceeded = 0;
    for (int n = 0; n < kTrials; ++n)
      exceeded += law.tail(heavy_errors(kPoints, sigma, random), kCoordinates) < 0.005;
    EXPECT_GT(exceeded, 0.003 * kTrials) << sigma;
    EXPECT_LT(exceeded, 0.010 * kTrials) << sigma;
  }
}

TEST(ResidualDistribution, TakesAPointForUnlikelyTheLaterTheLargerTheValidationErrorsAre) {
  const Eigen::VectorXd r = Eigen::VectorXd::Constant(kCoordinates, 3);
  double last = 0;
  for (const double distance2 : {1.0, 3.0, 6.0, 12.0}) {
    const double tail = ResidualDistribution(std::vector<double>(40, distance2)).tail(r, kCoordinates);
    EXPECT_GT(tail, last);
    last = tail;
  }
}

TEST(ResidualDistribution, OfFewValidationPointsIsNotExceededMoreOften) {
  constexpr int kTrials = 5000;
  Random random(20261125);
  int exceeded = 0;
  for (int n = 0; n < kTrials; ++n) {
    const ResidualDistribution law(distances2(heavy_errors(20, std::sqrt(0.5), random)));
    exceeded += law.tail(heavy_errors(kPoints, std::sqrt(0.5), random), kCoordinates) < 0.005;
  }
  EXPECT_LT(exceeded, 0.010 * kTrials);
}

TEST(ResidualDistribution, HasHeavierTailsThanTheNormalOne) {
  const Eigen::VectorXd r = Eigen::VectorXd::Constant(kCoordinates, 2);
  EXPECT_GT(ResidualDistribution(std::vector<double>(40, 3.0)).tail(r, kCoordinates),
            10 * ResidualDistribution{}.tail(r, kCoordinates));
}

}  // namespace
}  // namespace truepose
