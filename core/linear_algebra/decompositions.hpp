#pragma once

#include <Eigen/Core>
#include <vector>

namespace truepose {

// Compiled once: in every file that names one of Eigen's decompositions its templates are most of the compile
// time.

/// A = U diag(s) V', s >= 0 in descending order. With k the smaller dimension of A, U is rows x k and V
/// columns x k.
struct Svd {
  Eigen::MatrixXd U;
  Eigen::VectorXd s;
  Eigen::MatrixXd V;
};
Svd thin_svd(const Eigen::MatrixXd& A);

/// In descending order, as many as the smaller dimension of A.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& A);

/// The shortest x with the least |A x - b|. Singular values up to `tolerance` times the largest count as
/// zero.
Eigen::VectorXd smallest_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double tolerance);

/// A P = Q R, the columns in the order in which the pivoting took them.
struct PivotedQr {
  std::vector<int> order;
  Eigen::VectorXd pivots;  ///< magnitudes of the diagonal of R, as many as the smaller dimension of A
};
PivotedQr pivoted_qr(const Eigen::MatrixXd& A);

/// X with A X = B, A symmetric and positive definite to rounding, by LDL'. Reads the lower triangle of A.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

}  // namespace truepose
