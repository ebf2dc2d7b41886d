#pragma once

#include <Eigen/Core>

namespace truepose {

/// Eigenvalues of a symmetric tridiagonal matrix in ascending order, known to rounding of the largest: by QL
/// steps without square roots, several times faster than those that carry eigenvectors along.
/// Source: Reinsch, Algorithm 464, Eigenvalues of a real, symmetric, tridiagonal matrix, CACM 16, 1973.
///
/// @param diagonal  n
/// @param beside    n - 1, the diagonal next to it
Eigen::VectorXd tridiagonal_eigenvalues(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& beside);

}  // namespace truepose
