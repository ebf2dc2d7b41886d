#pragma once

#include "core/fit/measurement_model.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/singular_values.hpp"

namespace truepose {

/// Sum over the points of `fresh` of the squared error of their predictions that no unbiased estimate from
/// `data`, read with example::kSigma_mm, goes below on average.
///
/// Source: Cramér and Rao, by a singular value decomposition of its own.
inline double least_variance(const CalibratedCell& truth, const MeasurementData& data,
                             const MeasurementData& fresh) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J, J_fresh;
  residuals_with_jacobian(truth, data.points, f, J);
  residuals_with_jacobian(truth, fresh.points, f, J_fresh);
  const Eigen::VectorXd scale = J.colwise().norm().cwiseMax(1e-12).cwiseInverse();
  const SingularValues known = jacobi_singular_values(J * scale.asDiagonal());
  const Eigen::VectorXd inverse =
      (known.values.array() > 1e-9 * known.values.maxCoeff()).select(known.values.cwiseInverse(), 0);
  const Eigen::MatrixXd directions = J_fresh * scale.asDiagonal() * known.V * inverse.asDiagonal();
  return example::kSigma_mm * example::kSigma_mm * directions.squaredNorm();
}

}  // namespace truepose
