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

/// R of A = Q R, square: A's singular values, its V and its pivots, in as many rows as it has columns. A
/// itself where it has no more rows.
Eigen::MatrixXd triangular_factor(const Eigen::MatrixXd& A);

/// In descending order, as many as the smaller dimension of A.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& A);

/// The shortest x with the least |A x - b|. Singular values up to `tolerance` times the largest count as
/// zero.
Eigen::VectorXd smallest_solution(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double tolerance);

/// A P = Q R, the columns in the order in which the pivoting took them.
struct PivotedQr {
  std::vector<int> order;
  Eigen::MatrixXd R;  ///< square, with rows of zeros where A has fewer rows than columns

  Eigen::VectorXd pivots() const { return R.diagonal().cwiseAbs(); }
};
PivotedQr pivoted_qr(const Eigen::MatrixXd& A);

/// Orthonormal columns that span the x with A x = 0, of an A of that rank: as many as A has columns beyond
/// it.
Eigen::MatrixXd null_basis(const PivotedQr& A, int rank);

/// (A'A)^+, the singular values up to `tolerance` times the largest counted as zero, and how many are not.
struct InverseGram {
  Eigen::MatrixXd value;
  int rank = 0;
};
InverseGram inverse_gram(const Eigen::MatrixXd& A, double tolerance);

/// The trace of (A'A)^-1; infinite where A may have singular values up to `tolerance` times the largest.
double inverse_gram_trace(const Eigen::MatrixXd& A, double tolerance);

/// X with A X = B, A symmetric and positive definite to rounding, by LDL'. Reads the lower triangle of A.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// A^-1 of a square A of full rank.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& A);

/// In ascending order, of a symmetric A. Reads the lower triangle.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& A);

/// A = L L', A symmetric and positive definite. Reads the lower triangle of A.
class CholeskyFactor {
 public:
  explicit CholeskyFactor(Eigen::MatrixXd A);

  /// Whether A is positive definite. Without it the rest means nothing.
  bool succeeded() const { return succeeded_; }
  const Eigen::MatrixXd& L() const { return L_; }

  /// X with A X = B.
  Eigen::MatrixXd solve(Eigen::MatrixXd B) const;
  /// X with L X = B.
  Eigen::MatrixXd solve_lower(Eigen::MatrixXd B) const;
  /// A^-1.
  Eigen::MatrixXd inverse() const;
  /// L^-1.
  Eigen::MatrixXd inverse_lower() const;
  /// Logarithm of the determinant of A.
  double log_determinant() const;

 private:
  Eigen::MatrixXd L_;
  bool succeeded_ = false;
};

/// L of A = L L', A symmetric and positive definite, and its inverse. Reads the lower triangle of A. Does not
/// allocate.
Eigen::Matrix3d cholesky(const Eigen::Matrix3d& A);
Eigen::Matrix3d inverse_cholesky(const Eigen::Matrix3d& A);

/// X with A X = B in place of B, A symmetric and positive definite; its L in place of its lower triangle,
/// which alone is read. Does not allocate for a few tens of rows.
void solve_positive_in_place(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::MatrixXd> B);

/// x with A x = b in place of b, A square, by Gauss' elimination with row pivots, which leaves A changed; not
/// finite where A has less than full rank. Does not allocate.
void solve_in_place(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::VectorXd> b);

// Compiled once: every product of matrices of run-time size that Eigen expands in place costs about a second
// of compile time, and gains nothing there. Products of small fixed sizes are better written out.
//
// An operand may be a block of whole or part columns, or have a fixed number of rows, without being copied;
// any other expression is evaluated first. A vector is a matrix of one column, and costs no more than that.

/// A B.
Eigen::MatrixXd times(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B);

/// A B'.
Eigen::MatrixXd times_transposed(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                 const Eigen::Ref<const Eigen::MatrixXd>& B);

/// A' B.
Eigen::MatrixXd transposed_times(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                 const Eigen::Ref<const Eigen::MatrixXd>& B);

/// A' A.
Eigen::MatrixXd gram(const Eigen::Ref<const Eigen::MatrixXd>& A);

/// Adds A A' to the lower triangle of S; what is above means nothing afterwards. Does not allocate.
void add_outer_gram(const Eigen::Ref<const Eigen::MatrixXd>& A, Eigen::Ref<Eigen::MatrixXd> S);

/// A C A'.
Eigen::MatrixXd congruence(const Eigen::Ref<const Eigen::MatrixXd>& A,
                           const Eigen::Ref<const Eigen::MatrixXd>& C);
/// The blocks of three rows and columns on the diagonal of A C A', which is not formed.
std::vector<Eigen::Matrix3d> congruence_blocks(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                               const Eigen::Ref<const Eigen::MatrixXd>& C);
/// The diagonal of A C A', which is not formed, of a symmetric C.
Eigen::VectorXd congruence_diagonal(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                    const Eigen::Ref<const Eigen::MatrixXd>& C);

}  // namespace truepose
