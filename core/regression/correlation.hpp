#pragma once

#include <Eigen/Core>

#include "core/linear_algebra/products.hpp"

namespace truepose {

/// How alike the errors of two poses are, by their distance; 1 at distance zero. Both are given in the
/// squared distance u with every feature in units of its length scale.
enum class Correlation {
  SquaredExponential,  ///< exp(-u / 2)
  Matern52,            ///< (1 + a + a^2 / 3) exp(-a), a = sqrt(5 u)
};

/// Value and derivative to u, element by element. Source: Rasmussen and Williams, Gaussian Processes for
/// Machine Learning (2006), eqs 4.9 and 4.17.
template <typename Array>
Array correlation_of(Correlation kind, const Array& u) {
  if (kind == Correlation::SquaredExponential) return (-0.5 * u).exp();
  const Array a = (5 * u).sqrt();
  return (1 + a + a.square() / 3) * (-a).exp();
}

template <typename Array>
Array correlation_slope(Correlation kind, const Array& u) {
  if (kind == Correlation::SquaredExponential) return -0.5 * (-0.5 * u).exp();
  const Array a = (5 * u).sqrt();
  return -5.0 / 6 * (1 + a) * (-a).exp();
}

/// Squared distances between all rows of A and all rows of B.
inline Eigen::ArrayXXd squared_distances(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  Eigen::MatrixXd u = -2 * times_transposed(A, B);
  u.colwise() += A.rowwise().squaredNorm();
  u.rowwise() += B.rowwise().squaredNorm().transpose();
  return u.array().max(0);
}

}  // namespace truepose
