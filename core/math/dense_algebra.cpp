#include "core/math/dense_algebra.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "core/kernels/kernels.hpp"

namespace truepose {
namespace {

using InPlaceCholesky = Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>;
using ConstRef = Eigen::Ref<const Eigen::MatrixXd>;

kernels::StridedMatrix strided(const ConstRef& A) { return {A.data(), 1, A.outerStride()}; }
kernels::StridedMatrix transposed(const ConstRef& A) { return {A.data(), A.outerStride(), 1}; }

/// A B, or its lower triangle alone.
Eigen::MatrixXd product(const kernels::StridedMatrix& A, const kernels::StridedMatrix& B, Eigen::Index rows,
                        Eigen::Index depth, Eigen::Index columns, bool lower = false) {
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(rows, columns);
  kernels::best().multiply(A, B, 1, C.data(), rows, static_cast<int>(rows), static_cast<int>(depth),
                           static_cast<int>(columns), lower);
  return C;
}

/// R of A = Q R in as many rows as A has columns. `order` as kernels::Kernels::triangulate() has it.
Eigen::MatrixXd triangulated(const Eigen::MatrixXd& A, int* order) {
  constexpr Eigen::Index kLanes = kernels::kMostLanes;
  const Eigen::Index rows = (std::max(A.rows(), A.cols()) + kLanes - 1) / kLanes * kLanes;
  Eigen::MatrixXd work(rows, A.cols() + 3);  // and three columns of room
  work.topLeftCorner(A.rows(), A.cols()) = A;
  work.bottomRows(rows - A.rows()).setZero();
  kernels::best().triangulate(work.data(), rows, static_cast<int>(rows), static_cast<int>(A.cols()),
                              work.col(A.cols()).data(), order);
  return work.topLeftCorner(A.cols(), A.cols()).triangularView<Eigen::Upper>();
}

void solve_lower_in_place(const Eigen::MatrixXd& L, Eigen::MatrixXd& B, bool lower) {
  assert(L.rows() == B.rows());
  kernels::best().solve_lower(L.data(), L.rows(), static_cast<int>(L.rows()), B.data(), B.rows(),
                              static_cast<int>(B.cols()), lower);
}

}  // namespace

Svd thin_svd(const Eigen::MatrixXd& A) {
  // Jacobi's, of the triangular factor: ours have some tens of columns at most. Eigen's BDCSVD and its own
  // choice of a factor take longer to compile than all other decompositions together.
  if (A.cols() > A.rows()) {
    const Svd svd = thin_svd(A.transpose());
    return {svd.V, svd.s, svd.U};
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
  const Eigen::Index n = A.cols();
  const Eigen::MatrixXd R = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner> svd(
      R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::MatrixXd U = Eigen::MatrixXd::Zero(A.rows(), n);
  U.topRows(n) = svd.matrixU();
  U.applyOnTheLeft(qr.householderQ());
  return {U, svd.singularValues(), qr.colsPermutation() * svd.matrixV()};
}

Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& A) {
  return A.rows() <= A.cols() ? A : triangulated(A, nullptr);
}

Eigen::VectorXd singular_values(const Eigen::MatrixXd& A) {
  // From A'A where that loses no digits that are used: many times faster.
  constexpr double kBadly = 1e-6;  // of squares: below, the smallest is known to less than 1e-9 of itself
  const bool wide = A.cols() > A.rows();
  const Eigen::VectorXd squares = eigenvalues(wide ? times_transposed(A, A) : gram(A)).reverse();
  if (squares[squares.size() - 1] > kBadly * squares[0]) return squares.cwiseSqrt();
  return thin_svd(A).s;
}

Eigen::VectorXd smallest_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double tolerance) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> qr(A.rows(), A.cols());
  qr.setThreshold(tolerance);
  return qr.compute(A).solve(b);
}

PivotedQr pivoted_qr(const Eigen::MatrixXd& A) {
  PivotedQr qr{.order = std::vector<int>(static_cast<std::size_t>(A.cols())), .R = {}};
  std::iota(qr.order.begin(), qr.order.end(), 0);
  qr.R = triangulated(A, qr.order.data());
  return qr;
}

Eigen::MatrixXd null_basis(const PivotedQr& A, int rank) {
  const Eigen::Index size = A.R.cols(), open = size - rank;
  Eigen::MatrixXd basis(size, open);
  const Eigen::MatrixXd taken =
      -A.R.topLeftCorner(rank, rank).triangularView<Eigen::Upper>().solve(A.R.topRightCorner(rank, open));
  const std::span<const int> order{A.order};
  basis(order.first(static_cast<std::size_t>(rank)), Eigen::all) = taken;
  basis(order.subspan(static_cast<std::size_t>(rank)), Eigen::all).setIdentity();
  // The pivoting keeps what was taken small, and the identity is far from singular: this loses no digits.
  return CholeskyFactor(gram(basis)).solve_lower(basis.transpose()).transpose();
}

namespace {

/// The inverse of R' of a triangular factor; nothing where it might have singular values up to `tolerance`
/// times the largest.
std::optional<Eigen::MatrixXd> inverse_factor(const Eigen::MatrixXd& R, double tolerance) {
  const Eigen::Index n = R.cols();
  if (R.rows() != n || !(R.diagonal().array() != 0).all()) return std::nullopt;
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(n, n);
  solve_lower_in_place(R.transpose(), inverse, true);
  // The Frobenius norms bound the condition from above.
  if (!(R.norm() * inverse.norm() * tolerance < 1)) return std::nullopt;
  return inverse;
}

}  // namespace

double inverse_gram_trace(const Eigen::MatrixXd& A, double tolerance) {
  const auto inverse = inverse_factor(triangular_factor(A), tolerance);
  return inverse ? inverse->squaredNorm() : std::numeric_limits<double>::infinity();
}

InverseGram inverse_gram(const Eigen::MatrixXd& A, double tolerance) {
  const Eigen::MatrixXd R = triangular_factor(A);
  if (const auto inverse = inverse_factor(R, tolerance)) return {gram(*inverse), static_cast<int>(R.cols())};
  const Svd svd = thin_svd(R);
  const Eigen::VectorXd variance =
      svd.s.unaryExpr([&](double v) { return v > tolerance * svd.s[0] ? 1 / (v * v) : 0.0; });
  return {times_transposed(svd.V * variance.asDiagonal(), svd.V),
          static_cast<int>((variance.array() > 0).count())};
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  return Eigen::LDLT<Eigen::MatrixXd>(A).solve(B);
}

Eigen::MatrixXd inverse(const Eigen::MatrixXd& A) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(A).solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

CholeskyFactor::CholeskyFactor(Eigen::MatrixXd A) : L_{std::move(A)} {
  succeeded_ = kernels::best().factorise(L_.data(), L_.rows(), static_cast<int>(L_.rows())) > 0;
  L_.triangularView<Eigen::StrictlyUpper>().setZero();
}

Eigen::MatrixXd CholeskyFactor::solve(Eigen::MatrixXd B) const {
  B = solve_lower(std::move(B));
  kernels::best().solve_lower_transposed(L_.data(), L_.rows(), static_cast<int>(L_.rows()), B.data(),
                                         B.rows(), static_cast<int>(B.cols()));
  return B;
}

Eigen::MatrixXd CholeskyFactor::solve_lower(Eigen::MatrixXd B) const {
  solve_lower_in_place(L_, B, false);
  return B;
}

Eigen::MatrixXd CholeskyFactor::inverse() const { return gram(inverse_lower()); }

Eigen::MatrixXd CholeskyFactor::inverse_lower() const {
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(L_.rows(), L_.cols());
  solve_lower_in_place(L_, inverse, true);
  return inverse;
}

double CholeskyFactor::log_determinant() const { return 2 * L_.diagonal().array().log().sum(); }

Eigen::Matrix3d cholesky(const Eigen::Matrix3d& A) {
  Eigen::Matrix3d L = Eigen::Matrix3d::Zero();
  L(0, 0) = std::sqrt(A(0, 0));
  L(1, 0) = A(1, 0) / L(0, 0);
  L(2, 0) = A(2, 0) / L(0, 0);
  L(1, 1) = std::sqrt(A(1, 1) - L(1, 0) * L(1, 0));
  L(2, 1) = (A(2, 1) - L(2, 0) * L(1, 0)) / L(1, 1);
  L(2, 2) = std::sqrt(A(2, 2) - L(2, 0) * L(2, 0) - L(2, 1) * L(2, 1));
  return L;
}

Eigen::Matrix3d inverse_cholesky(const Eigen::Matrix3d& A) {
  const Eigen::Matrix3d L = cholesky(A);
  Eigen::Matrix3d W = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) W(i, i) = 1 / L(i, i);
  W(1, 0) = -L(1, 0) * W(0, 0) * W(1, 1);
  W(2, 1) = -L(2, 1) * W(1, 1) * W(2, 2);
  W(2, 0) = -(L(2, 0) * W(0, 0) + L(2, 1) * W(1, 0)) * W(2, 2);
  return W;
}

void solve_positive_in_place(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::MatrixXd> B) {
  const InPlaceCholesky factor(A);
  for (Eigen::Index c = 0; c < B.cols(); ++c) factor.solveInPlace(B.col(c));
}

void solve_in_place(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::VectorXd> b) {
  const Eigen::Index n = A.rows();
  for (Eigen::Index k = 0; k < n; ++k) {
    Eigen::Index pivot = k;
    for (Eigen::Index i = k + 1; i < n; ++i) {
      if (std::abs(A(i, k)) > std::abs(A(pivot, k))) pivot = i;
    }
    for (Eigen::Index j = k; pivot != k && j < n; ++j) std::swap(A(k, j), A(pivot, j));
    std::swap(b[k], b[pivot]);
    for (Eigen::Index i = k + 1; i < n; ++i) A(i, k) /= A(k, k);
    for (Eigen::Index j = k + 1; j < n; ++j) {
      for (Eigen::Index i = k + 1; i < n; ++i) A(i, j) -= A(i, k) * A(k, j);
    }
    for (Eigen::Index i = k + 1; i < n; ++i) b[i] -= A(i, k) * b[k];
  }
  for (Eigen::Index k = n; k-- > 0;) {
    b[k] /= A(k, k);
    for (Eigen::Index i = 0; i < k; ++i) b[i] -= A(i, k) * b[k];
  }
}

Eigen::MatrixXd times(const ConstRef& A, const ConstRef& B) {
  assert(A.cols() == B.rows());
  if (B.cols() == 1) return A * B.col(0);
  return product(strided(A), strided(B), A.rows(), A.cols(), B.cols());
}

Eigen::MatrixXd times_transposed(const ConstRef& A, const ConstRef& B) {
  assert(A.cols() == B.cols());
  return product(strided(A), transposed(B), A.rows(), A.cols(), B.rows());
}

Eigen::MatrixXd transposed_times(const ConstRef& A, const ConstRef& B) {
  assert(A.rows() == B.rows());
  if (B.cols() == 1) return A.transpose() * B.col(0);
  return product(transposed(A), strided(B), A.cols(), A.rows(), B.cols());
}

Eigen::MatrixXd gram(const ConstRef& A) {
  Eigen::MatrixXd G = product(transposed(A), strided(A), A.cols(), A.rows(), A.cols(), true);
  G.triangularView<Eigen::StrictlyUpper>() = G.transpose();
  return G;
}

void add_outer_gram(const ConstRef& A, Eigen::Ref<Eigen::MatrixXd> S) {
  assert(S.rows() == A.rows() && S.cols() == A.rows());
  const int n = static_cast<int>(A.rows());
  kernels::best().multiply(strided(A), transposed(A), 1, S.data(), S.outerStride(), n,
                           static_cast<int>(A.cols()), n, true);
}

Eigen::MatrixXd congruence(const ConstRef& A, const ConstRef& C) { return times_transposed(times(A, C), A); }

std::vector<Eigen::Matrix3d> congruence_blocks(const ConstRef& A, const ConstRef& C) {
  const Eigen::MatrixXd AC = times(A, C);
  std::vector<Eigen::Matrix3d> blocks;
  for (Eigen::Index row = 0; row < A.rows(); row += 3)
    blocks.push_back(times_transposed(AC.middleRows(row, 3), A.middleRows(row, 3)));
  return blocks;
}

Eigen::VectorXd congruence_diagonal(const ConstRef& A, const ConstRef& C) {
  constexpr Eigen::Index kStrip = 8;
  const Eigen::Index n = C.cols();
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(A.rows());
  for (Eigen::Index first = 0; first < n; first += kStrip) {
    const Eigen::Index width = std::min(kStrip, n - first);
    Eigen::MatrixXd strip = C.block(first, first, n - first, width);
    strip.bottomRows(n - first - width) *= 2;  // for what is right of the diagonal
    const Eigen::MatrixXd products = times(A.rightCols(n - first), strip);
    for (Eigen::Index k = 0; k < width; ++k)
      diagonal.array() += products.col(k).array() * A.col(first + k).array();
  }
  return diagonal;
}

}  // namespace truepose
