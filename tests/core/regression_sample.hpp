#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "core/field/regressor.hpp"
#include "core/math/random.hpp"

namespace truepose {

inline constexpr int kFeatures = 4, kTargets = 3;

/// A smooth field of the size of a robot's residuals, mm.
inline Eigen::Vector3d field(const Eigen::VectorXd& x) {
  return 0.2 * Eigen::Vector3d{std::sin(1.5 * x[0]) + 0.5 * x[1] * std::cos(x[2]),
                               std::cos(1.5 * x[1]) * std::sin(x[0]), std::sin(x[0] + x[1])};
}

/// N points of the field, or of zero, with noise.
inline RegressionData sample(int N, double noise, std::uint64_t seed, bool with_field = true) {
  Random random{seed};
  RegressionData data{Eigen::MatrixXd(N, kFeatures), Eigen::MatrixXd::Zero(N, kTargets), {}};
  for (int i = 0; i < N; ++i) {
    for (double& x : data.X.row(i)) x = random.uniform(-1.5, 1.5);
    if (with_field) data.Y.row(i) = field(data.X.row(i).transpose());
    for (double& y : data.Y.row(i)) y += noise * random.normal();
  }
  return data;
}

inline RegressorPtr fit(const RegressionMethod& method, const RegressionData& data) {
  const auto fitted = fit_regressor(method, data);
  EXPECT_TRUE(fitted) << (fitted ? "" : fitted.error());
  return fitted.value_or(nullptr);
}

inline Eigen::VectorXd predict(const Regressor& regressor, const Eigen::VectorXd& x) {
  Eigen::VectorXd y(kTargets);
  regressor.predict(x, y);
  return y;
}

/// rms of what is left of the targets, over their rms.
inline double part_left(const Regressor& regressor, const RegressionData& fresh) {
  double left = 0;
  for (Eigen::Index i = 0; i < fresh.X.rows(); ++i)
    left += (fresh.Y.row(i).transpose() - predict(regressor, fresh.X.row(i))).squaredNorm();
  return std::sqrt(left / fresh.Y.squaredNorm());
}

}  // namespace truepose
