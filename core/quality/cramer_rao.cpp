#include "core/quality/cramer_rao.hpp"

#include <cmath>

#include "core/fit/identifiability.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {

Eigen::MatrixXd position_jacobian(const CalibratedCell& cell, std::span<const JointVector> poses) {
  Eigen::VectorXd p_WS_mm;
  Eigen::MatrixXd J;
  predict_with_jacobian(cell, poses, p_WS_mm, J);
  return J;
}

Eigen::MatrixXd whitened_basis(const Eigen::MatrixXd& J) {
  const Eigen::VectorXd inverse_norm = column_norms(J).cwiseInverse();
  const Svd svd = thin_svd(J * inverse_norm.asDiagonal());
  const Eigen::Index rank = (svd.s.array() > kRankTolerance * svd.s[0]).count();
  return inverse_norm.asDiagonal() * svd.V.leftCols(rank) * svd.s.head(rank).cwiseInverse().asDiagonal();
}

double cramer_rao_rms_mm(const CalibratedCell& truth, std::span<const JointVector> measured,
                         std::span<const JointVector> elsewhere, double sigma_mm) {
  const Eigen::MatrixXd basis = whitened_basis(position_jacobian(truth, measured));
  const double spread = (position_jacobian(truth, elsewhere) * basis).norm();
  return sigma_mm * spread / std::sqrt(static_cast<double>(elsewhere.size()));
}

}  // namespace truepose
