#pragma once

#include <Eigen/Core>

#include "core/field/regressor.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {

/// How alike the errors of two poses are, by their distance; 1 at distance zero. Both are given in the
/// squared distance u with every feature in units of its length scale.
enum class Correlation {
  SquaredExponential,  ///< exp(-u / 2)
  Matern52,            ///< (1 + a + a^2 / 3) exp(-a), a = sqrt(5 u)
};

/// Value, and derivative to u from that value, element by element. Source: Rasmussen and Williams, Gaussian
/// Processes for Machine Learning (2006), eqs 4.9 and 4.17.
template <typename Array>
Array correlation_of(Correlation kind, const Array& u) {
  if (kind == Correlation::SquaredExponential) return (-0.5 * u).exp();
  const Array a = (5 * u).sqrt();
  return (1 + a + a.square() / 3) * (-a).exp();
}

template <typename Array>
Array correlation_slope(Correlation kind, const Array& u, const Array& correlation) {
  if (kind == Correlation::SquaredExponential) return -0.5 * correlation;
  const Array a = (5 * u).sqrt();
  return -5.0 / 6 * correlation * (1 + a) / (1 + a + a.square() / 3);
}

/// Squared distances between all rows of A and all rows of B.
inline Eigen::ArrayXXd squared_distances(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  Eigen::MatrixXd u = -2 * times_transposed(A, B);
  u.colwise() += A.rowwise().squaredNorm();
  u.rowwise() += B.rowwise().squaredNorm().transpose();
  return u.array().max(0);
}

/// What a Gaussian process assumes of the field: one length scale per feature, and the noise.
struct GaussianProcessHyper {
  Correlation correlation = Correlation::Matern52;
  Eigen::VectorXd lengths;  ///< d, in units of the features' spread
  double noise_ratio = 0;   ///< variance of the noise over that of the signal, the same for every target
};

/// Cholesky factor of C = R + noise_ratio I, with the least jitter that makes it positive definite.
CholeskyFactor factorise(const Eigen::MatrixXd& Z, const GaussianProcessHyper& hyper);

/// Negative logarithm of the evidence for hyper-parameters, with a weak prior on them.
///
/// Every target is a zero-mean Gaussian process with covariance s_j^2 C; the s_j^2 are replaced by their
/// estimates y_j' C^-1 y_j / N, so that one factorisation serves all targets.
/// Source: Rasmussen and Williams (2006), eqs 2.30 and 5.9, with the signal variance concentrated out.
class MarginalLikelihood {
 public:
  /// @param Z  N x d features at unit spread
  /// @param T  N x m targets at unit scale
  MarginalLikelihood(Eigen::MatrixXd Z, Eigen::MatrixXd T, Correlation correlation);

  /// @param log_hyper  logarithms of the d lengths, then of the noise ratio above its floor
  double operator()(const Eigen::VectorXd& log_hyper, Eigen::VectorXd& gradient) const;

  GaussianProcessHyper hyper(const Eigen::VectorXd& log_hyper) const;

 private:
  double prior(const Eigen::VectorXd& log_hyper, Eigen::VectorXd& gradient) const;

  Eigen::MatrixXd Z_, T_;
  Correlation correlation_;
};

/// Gaussian process of zero mean, one length scale per feature, correlation and noise ratio shared by the
/// targets. The hyper-parameters maximise the evidence, over a part of the points where they are many, from
/// a few fixed starts. Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006).
///
/// Hyper-parameters: `matern` (1, or 0 for squared exponential), `noise_ratio`, `length.0` to `length.<d-1>`.
extern const RegressionMethod kGaussianProcess;

/// The regressor that a state was taken from: it predicts the same to the last bit. Errors: fault_of(data); a
/// hyper-parameter missing or out of its range, which the sentence names.
std::expected<RegressorPtr, std::string> restore_gaussian_process(const RegressorState& state);

}  // namespace truepose
