#include "core/evaluation/drift_residuals.hpp"

#include "core/calibration/measurement_model.hpp"
#include "core/linear_algebra/decompositions.hpp"
#include "core/linear_algebra/products.hpp"

namespace truepose {

std::expected<DriftResiduals, std::string> drift_residuals(const DriftReference& reference,
                                                           const CalibratedCell& cell,
                                                           std::span<const Measurement> points) {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, f, J);
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(f.size(), f.size());
  if (reference.covariance.size() > 0) S = congruence(J, reference.covariance);
  Eigen::Index row = 0;
  for (const Measurement& point : points) {
    S.block<3, 3>(row, row) += reading_covariance(point.p_WS_mm, reference.noise);
    row += 3;
  }
  const CholeskyFactor factor(S);
  if (!factor.succeeded())
    return std::unexpected("the noise of a point must be above 0 and the model's covariance not negative");
  const Eigen::MatrixXd inverse = factor.inverse_lower();
  return DriftResiduals{
      .r = -times(inverse, f), .J = times(inverse, J), .inverse = inverse, .S = std::move(S)};
}

}  // namespace truepose
