#pragma once

#include <Eigen/Core>

#include "core/linear_algebra/decompositions.hpp"
#include "core/regression/correlation.hpp"

namespace truepose {

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

}  // namespace truepose
