#include "core/regression/marginal_likelihood.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "core/linear_algebra/products.hpp"

namespace truepose {
namespace {

/// Priors on the logarithms: wide enough to let data speak, narrow enough that a length of a feature that
/// says nothing, or the noise of data without noise, stays where the matrices are well conditioned.
struct LogPrior {
  double mean, sigma;
};
constexpr LogPrior kLength{1.5, 1.5};
constexpr LogPrior kNoise{-2, 3};

/// Least ratio of noise to signal: keeps rounding errors out of predictions where data are free of noise.
constexpr double kLeastNoiseRatio = 1e-7;

}  // namespace

CholeskyFactor factorise(const Eigen::MatrixXd& Z, const GaussianProcessHyper& hyper) {
  const Eigen::MatrixXd scaled = Z * hyper.lengths.cwiseInverse().asDiagonal();
  Eigen::MatrixXd C = correlation_of(hyper.correlation, squared_distances(scaled, scaled)).matrix();
  C.diagonal().setConstant(1 + hyper.noise_ratio);
  CholeskyFactor factor{C};
  for (double jitter = 1e-10; !factor.succeeded() && jitter < 1; jitter *= 10) {
    C.diagonal().setConstant(1 + hyper.noise_ratio + jitter);
    factor = CholeskyFactor{C};
  }
  return factor;
}

MarginalLikelihood::MarginalLikelihood(Eigen::MatrixXd Z, Eigen::MatrixXd T, Correlation correlation)
    : Z_{std::move(Z)}, T_{std::move(T)}, correlation_{correlation} {}

GaussianProcessHyper MarginalLikelihood::hyper(const Eigen::VectorXd& log_hyper) const {
  return {correlation_, log_hyper.head(Z_.cols()).array().exp(),
          kLeastNoiseRatio + std::exp(log_hyper[Z_.cols()])};
}

double MarginalLikelihood::prior(const Eigen::VectorXd& log_hyper, Eigen::VectorXd& gradient) const {
  double value = 0;
  for (Eigen::Index k = 0; k < log_hyper.size(); ++k) {
    const LogPrior& prior = k < Z_.cols() ? kLength : kNoise;
    const double deviation = (log_hyper[k] - prior.mean) / prior.sigma;
    value += 0.5 * deviation * deviation;
    gradient[k] += deviation / prior.sigma;
  }
  return value;
}

double MarginalLikelihood::operator()(const Eigen::VectorXd& log_hyper, Eigen::VectorXd& gradient) const {
  const Eigen::Index N = Z_.rows(), d = Z_.cols();
  const double m = static_cast<double>(T_.cols());
  const GaussianProcessHyper at = hyper(log_hyper);
  gradient = Eigen::VectorXd::Zero(d + 1);
  const CholeskyFactor factor = factorise(Z_, at);
  if (!log_hyper.allFinite() || !factor.succeeded()) return std::numeric_limits<double>::infinity();

  const Eigen::MatrixXd alpha = factor.solve(T_);
  const Eigen::VectorXd signal = T_.cwiseProduct(alpha).colwise().sum().transpose() / static_cast<double>(N);
  const double value =
      0.5 * (static_cast<double>(N) * signal.array().log().sum() + m * factor.log_determinant());

  // The derivative to a parameter p is tr(W dC/dp) / 2.
  Eigen::MatrixXd W = m * factor.inverse();
  W -= times_transposed(alpha * signal.cwiseInverse().asDiagonal(), alpha);
  gradient[d] = 0.5 * std::exp(log_hyper[d]) * W.trace();

  // dC/dlog l_k = -2 R'(u) (z_ik - z_jk)^2 / l_k^2, summed without forming it: A is symmetric.
  const Eigen::MatrixXd scaled = Z_ * at.lengths.cwiseInverse().asDiagonal();
  const Eigen::ArrayXXd u = squared_distances(scaled, scaled);
  const Eigen::MatrixXd A = (W.array() * correlation_slope(correlation_, u)).matrix();
  const Eigen::VectorXd row_sums = A.rowwise().sum();
  gradient.head(d) = -2 * (transposed_times(scaled.cwiseAbs2(), row_sums) -
                           scaled.cwiseProduct(times(A, scaled)).colwise().sum().transpose());
  return value + prior(log_hyper, gradient);
}

}  // namespace truepose
