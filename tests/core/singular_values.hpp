#pragma once

#include <Eigen/Core>
#include <cmath>

namespace truepose {

/// A = U diag(values) V', with no more columns than rows.
struct SingularValues {
  Eigen::VectorXd values;  ///< in no order
  Eigen::MatrixXd V;
};

/// Source: M. R. Hestenes, Inversion of matrices by biorthogonalization, 1958: pairs of columns are turned
/// until all are orthogonal. Eigen's decompositions share code with those of core, and take many times as
/// long to compile.
inline SingularValues jacobi_singular_values(Eigen::MatrixXd A) {
  constexpr double kOrthogonal = 1e-13;
  const double nothing = 1e-26 * A.squaredNorm();  // of a column that the others span
  Eigen::MatrixXd V = Eigen::MatrixXd::Identity(A.cols(), A.cols());
  const auto turn = [](Eigen::MatrixXd& M, Eigen::Index p, Eigen::Index q, double c, double s) {
    for (Eigen::Index i = 0; i < M.rows(); ++i) {
      const double of_p = M(i, p), of_q = M(i, q);
      M(i, p) = c * of_p - s * of_q;
      M(i, q) = s * of_p + c * of_q;
    }
  };
  for (bool turned = true; turned;) {
    turned = false;
    for (Eigen::Index p = 0; p < A.cols(); ++p) {
      for (Eigen::Index q = p + 1; q < A.cols(); ++q) {
        const double pp = A.col(p).squaredNorm(), qq = A.col(q).squaredNorm(), pq = A.col(p).dot(A.col(q));
        if (std::abs(pq) <= kOrthogonal * std::sqrt(pp * qq) || pp < nothing || qq < nothing) continue;
        turned = true;
        const double cot = (qq - pp) / (2 * pq);
        const double tan = std::copysign(1.0, cot) / (std::abs(cot) + std::hypot(1.0, cot));
        const double cos = 1 / std::hypot(1.0, tan);
        turn(A, p, q, cos, cos * tan);
        turn(V, p, q, cos, cos * tan);
      }
    }
  }
  return {A.colwise().norm(), V};
}

}  // namespace truepose
