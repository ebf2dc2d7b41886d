#include "core/calibration/observability.hpp"

#include <Eigen/QR>
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
  // Data and priors as one least-squares problem, in units of the prior where there is one and of the
  // column's norm elsewhere.
  const auto has_prior = prior_sigma.array().isFinite();
  const Eigen::VectorXd scale = has_prior.select(prior_sigma, column_norms(J).cwiseInverse());
  Eigen::MatrixXd rows(J.rows() + J.cols(), J.cols());
  rows << J * scale.asDiagonal(), Eigen::MatrixXd{has_prior.cast<double>().matrix().asDiagonal()};
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rows);
  const Eigen::MatrixXd R = qr.matrixQR().topRows(J.cols()).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(R, Eigen::ComputeFullV);

  const Eigen::ArrayXd s = svd.singularValues();
  const auto determined = s > kRankTolerance * s[0];
  const Eigen::MatrixXd part = svd.matrixV().cwiseAbs2();  // parameters x directions
  const Eigen::VectorXd posterior = part * determined.select(s.square().inverse(), 0.0).matrix();
  const Eigen::VectorXd open = part * determined.select(0.0, Eigen::ArrayXd::Ones(s.size())).matrix();

  constexpr double kNoPart = 1e-6;
  const auto without_prior = (open.array() < kNoPart).cast<double>();
  return has_prior.select(1 - posterior.array(), without_prior);
}

}  // namespace truepose
