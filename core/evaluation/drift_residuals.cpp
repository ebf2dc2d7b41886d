#include "core/evaluation/drift_residuals.hpp"

#include <Eigen/Cholesky>

#include "core/calibration/measurement_model.hpp"

namespace truepose {

std::expected<DriftResiduals, std::string> drift_residuals(const DriftReference& reference,
                                                           const CalibratedCell& cell,
                                                           std::span<const Measurement> points) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, f, J);
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(f.size(), f.size());
  if (reference.covariance.size() > 0) S = J * reference.covariance * J.transpose();
  Eigen::Index row = 0;
  for (const Measurement& point : points) {
    S.block<3, 3>(row, row) += reading_covariance(point.p_WS_mm, reference.noise);
    row += 3;
  }
  const Eigen::LLT<Eigen::MatrixXd> cholesky(S);
  if (cholesky.info() != Eigen::Success)
    return std::unexpected("the noise of a point must be above 0 and the model's covariance not negative");
  const Eigen::MatrixXd inverse = cholesky.matrixL().solve(Eigen::MatrixXd::Identity(S.rows(), S.cols()));
  return DriftResiduals{.r = -(inverse * f), .J = inverse * J, .inverse = inverse, .S = std::move(S)};
}

}  // namespace truepose
