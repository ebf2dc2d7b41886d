#include "core/linear_algebra/decompositions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>

#include "core/kernels/kernels.hpp"

namespace truepose {

Svd thin_svd(const Eigen::MatrixXd& A) {
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(A, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& A) {
  constexpr Eigen::Index kLanes = kernels::kMostLanes;
  if (A.rows() <= A.cols()) return A;
  const Eigen::Index rows = (A.rows() + kLanes - 1) / kLanes * kLanes;
  Eigen::MatrixXd work(rows, A.cols() + 1);  // and a column of room
  work.topLeftCorner(A.rows(), A.cols()) = A;
  work.bottomRows(rows - A.rows()).setZero();
  kernels::best().triangulate(work.data(), rows, static_cast<int>(rows), static_cast<int>(A.cols()),
                              work.col(A.cols()).data());
  return work.topLeftCorner(A.cols(), A.cols()).triangularView<Eigen::Upper>();
}

Eigen::VectorXd singular_values(const Eigen::MatrixXd& A) {
  // From A'A where that loses no digits that anybody reads: many times faster.
  constexpr double kBadly = 1e-6;  // of squares: below, the smallest is known to less than 1e-9 of itself
  const bool wide = A.cols() > A.rows();
  const Eigen::MatrixXd gram = wide ? Eigen::MatrixXd{A * A.transpose()} : Eigen::MatrixXd{A.transpose() * A};
  const Eigen::VectorXd squares =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gram, Eigen::EigenvaluesOnly).eigenvalues().reverse();
  if (squares[squares.size() - 1] > kBadly * squares[0]) return squares.cwiseSqrt();
  return Eigen::BDCSVD<Eigen::MatrixXd>(A).singularValues();
}

Eigen::VectorXd smallest_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double tolerance) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr(A.rows(), A.cols());
  qr.setThreshold(tolerance);
  return qr.compute(A).solve(b);
}

PivotedQr pivoted_qr(const Eigen::MatrixXd& A) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  const auto& order = qr.colsPermutation().indices();
  return {{order.data(), order.data() + order.size()}, qr.matrixQR().diagonal().cwiseAbs()};
}

Eigen::MatrixXd null_basis(const Eigen::MatrixXd& A, int rank) {
  const Eigen::Index open = A.cols() - rank;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(A.cols(), A.cols()).rightCols(open);
  const auto R = qr.matrixQR().topRows(rank);
  basis.topRows(rank) = -R.leftCols(rank).triangularView<Eigen::Upper>().solve(R.rightCols(open));
  basis = (qr.colsPermutation() * basis).eval();
  const Eigen::MatrixXd Q =
      Eigen::HouseholderQR<Eigen::MatrixXd>(basis).householderQ() * Eigen::MatrixXd::Identity(A.cols(), open);
  return Q;
}

InverseGram inverse_gram(const Eigen::MatrixXd& A, double tolerance) {
  const Eigen::MatrixXd R = triangular_factor(A);
  const Eigen::Index n = A.cols();
  if (R.rows() == n && (R.diagonal().array() != 0).all()) {
    const Eigen::MatrixXd inverse = R.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(n, n));
    // The Frobenius norms bound the condition from above.
    if (R.norm() * inverse.norm() * tolerance < 1)
      return {inverse * inverse.transpose(), static_cast<int>(n)};
  }
  const Svd svd = thin_svd(R);
  const Eigen::VectorXd variance =
      svd.s.unaryExpr([&](double v) { return v > tolerance * svd.s[0] ? 1 / (v * v) : 0.0; });
  return {svd.V * variance.asDiagonal() * svd.V.transpose(),
          static_cast<int>((variance.array() > 0).count())};
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return Eigen::LDLT<Eigen::MatrixXd>(A).solve(B);
}

}  // namespace truepose
