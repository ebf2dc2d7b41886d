#pragma once

#include <Eigen/Core>

namespace truepose {

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

/// A C A'.
Eigen::MatrixXd congruence(const Eigen::Ref<const Eigen::MatrixXd>& A,
                           const Eigen::Ref<const Eigen::MatrixXd>& C);
/// The diagonal of A C A', which is not formed.
Eigen::VectorXd congruence_diagonal(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                    const Eigen::Ref<const Eigen::MatrixXd>& C);

}  // namespace truepose
