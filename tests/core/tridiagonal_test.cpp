#include "core/math/tridiagonal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace truepose {
namespace {

using Eigen::VectorXd;

TEST(TridiagonalEigenvalues, AreThoseOfAChainOfSprings) {
  for (const Eigen::Index n : {1, 2, 3, 8, 27, 100}) {
    const VectorXd found = tridiagonal_eigenvalues(VectorXd::Constant(n, 2), VectorXd::Constant(n - 1, -1));
    for (Eigen::Index k = 0; k < n; ++k) {
      const double angle = std::numbers::pi * static_cast<double>(k + 1) / static_cast<double>(n + 1);
      EXPECT_NEAR(found[k], 2 - 2 * std::cos(angle), 1e-14 * static_cast<double>(n)) << n << ": " << k;
    }
  }
}

TEST(TridiagonalEigenvalues, AreKnownToRoundingOfTheLargestWhereTheyAreFarApart) {
  // The Clement matrix has -n + 1, -n + 3 .. n - 1; its square root of products stands beside a zero
  // diagonal.
  constexpr Eigen::Index kSize = 40;
  VectorXd beside(kSize - 1);
  for (Eigen::Index k = 0; k < beside.size(); ++k)
    beside[k] = std::sqrt(static_cast<double>((k + 1) * (kSize - 1 - k)));
  const VectorXd found = tridiagonal_eigenvalues(VectorXd::Zero(kSize), beside);
  for (Eigen::Index k = 0; k < kSize; ++k)
    EXPECT_NEAR(found[k], static_cast<double>(2 * k - kSize + 1), 1e-12) << k;
}

TEST(TridiagonalEigenvalues, AreTheDiagonalInOrderWhereNothingStandsBesideIt) {
  const VectorXd found = tridiagonal_eigenvalues(Eigen::Vector4d(3, -1, 0, 2), Eigen::Vector3d::Zero());
  EXPECT_EQ(found, VectorXd(Eigen::Vector4d(-1, 0, 2, 3)));
}

}  // namespace
}  // namespace truepose
