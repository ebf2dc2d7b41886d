#pragma once

#include <Eigen/SVD>

#include "core/identify/measurement_model.hpp"
#include "tests/core/example_arms.hpp"

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
  Eigen::BDCSVD<Eigen::MatrixXd> svd(J * scale.asDiagonal(), Eigen::ComputeThinV);
  svd.setThreshold(1e-9);
  const Eigen::Index rank = svd.rank();
  const Eigen::MatrixXd directions = J_fresh * scale.asDiagonal() * svd.matrixV().leftCols(rank) *
                                     svd.singularValues().head(rank).cwiseInverse().asDiagonal();
  return example::kSigma_mm * example::kSigma_mm * directions.squaredNorm();
}

}  // namespace truepose
