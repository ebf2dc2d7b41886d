#include "core/calibration/observability.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cmath>

#include "core/calibration/identifiability.hpp"

namespace truepose {

ObservabilityIndices observability(const Eigen::MatrixXd& scaled, int poses) {
  const Eigen::ArrayXd s = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
  const double largest = s[0], smallest = s[s.size() - 1];
  return {.o1 = std::exp(s.log().mean()) / std::sqrt(static_cast<double>(poses)),
          .o2 = smallest / largest,
          .o3 = smallest,
          .o4 = smallest * smallest / largest,
          .o5 = 1 / s.inverse().sum()};
}

Eigen::VectorXd data_share(const Eigen::MatrixXd& J, const Eigen::VectorXd& prior_sigma) {
  // Unit prior variance where there is a prior, unit column norm where there is none.
  const auto has_prior = prior_sigma.array().isFinite();
  const Eigen::VectorXd scale = has_prior.select(prior_sigma, column_norms(J).cwiseInverse());
  const Eigen::MatrixXd scaled = J * scale.asDiagonal();
  Eigen::MatrixXd information = scaled.transpose() * scaled;
  information.diagonal() += has_prior.cast<double>().matrix();

  // Directions that neither data nor priors determine: an information is a square, so its digits end at
  // 1e-13.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  const Eigen::ArrayXd& values = eigen.eigenvalues().array();
  const auto determined = values > 1e-13 * values.maxCoeff();
  const Eigen::MatrixXd part = eigen.eigenvectors().cwiseAbs2();  // parameters x directions
  const Eigen::VectorXd posterior = part * determined.select(values.inverse(), 0.0).matrix();
  const Eigen::VectorXd open = part * determined.select(0.0, Eigen::ArrayXd::Ones(values.size())).matrix();

  const auto without_prior = (open.array() < 1e-6).cast<double>();
  return has_prior.select(1 - posterior.array(), without_prior);
}

}  // namespace truepose
