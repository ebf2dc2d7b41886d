#include "core/regression/gaussian_process.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/random.hpp"
#include "core/regression/lbfgs.hpp"
#include "core/regression/marginal_likelihood.hpp"
#include "core/regression/point_cloud.hpp"

namespace truepose {
namespace {

/// Points that choose among the starts, and that refine the winner: the cost of one evaluation grows with
/// their cube, what they add to d + 1 numbers does not.
constexpr int kStartPoints = 100;
constexpr int kRefinePoints = 250;

std::string length_name(Eigen::Index k) { return "length." + std::to_string(k); }

GaussianProcessHyper hyper_of(const RegressorState& state) {
  GaussianProcessHyper hyper;
  hyper.correlation = state.hyper.at("matern") > 0 ? Correlation::Matern52 : Correlation::SquaredExponential;
  hyper.noise_ratio = state.hyper.at("noise_ratio");
  hyper.lengths.resize(state.X.cols());
  for (Eigen::Index k = 0; k < hyper.lengths.size(); ++k) hyper.lengths[k] = state.hyper.at(length_name(k));
  return hyper;
}

class GaussianProcess final : public Regressor {
 public:
  explicit GaussianProcess(const RegressorState& state)
      : state_{state},
        hyper_{hyper_of(state)},
        scale_{state.X},
        factor_{factorise(scale_.apply_all(state.X), hyper_)},
        points_{scale_.apply_all(state.X) * hyper_.lengths.cwiseInverse().asDiagonal()},
        alpha_{Eigen::MatrixXd::Zero(points_.blocks() * kBlock, state.Y.cols())} {
    alpha_.topRows(state.Y.rows()) = factor_.solve(state.Y);
    signal_ = state.Y.cwiseProduct(alpha_.topRows(state.Y.rows())).colwise().mean();
  }

  void predict(const Eigen::Ref<const Eigen::VectorXd>& x,
               Eigen::Ref<Eigen::VectorXd> y) const noexcept override {
    const Features z = scaled(x);
    y.setZero();
    for (int b = 0; b < points_.blocks(); ++b) {
      const BlockedPoints::Block r = correlation_of(hyper_.correlation, points_.squared_distances(z, b));
      for (Eigen::Index j = 0; j < y.size(); ++j)
        y[j] += (alpha_.col(j).segment<kBlock>(b * kBlock).array() * r).sum();
    }
  }

  std::optional<Eigen::VectorXd> variance(const Eigen::Ref<const Eigen::VectorXd>& x) const override {
    const Features z = scaled(x);
    Eigen::VectorXd r(alpha_.rows());
    for (int b = 0; b < points_.blocks(); ++b)
      r.segment<kBlock>(b * kBlock) = correlation_of(hyper_.correlation, points_.squared_distances(z, b));
    const double known = factor_.solve_lower(r.head(state_.Y.rows())).squaredNorm();
    return signal_ * std::max(0.0, 1 - known);
  }

  RegressorState state() const override { return state_; }

 private:
  static constexpr int kBlock = BlockedPoints::kBlock;

  Features scaled(const Eigen::Ref<const Eigen::VectorXd>& x) const {
    return scale_.apply(x).cwiseQuotient(hyper_.lengths);
  }

  RegressorState state_;
  GaussianProcessHyper hyper_;
  FeatureScale scale_;
  CholeskyFactor factor_;
  BlockedPoints points_;
  Eigen::MatrixXd alpha_;
  Eigen::VectorXd signal_;
};

/// The first `wanted` points of a fixed shuffle.
MarginalLikelihood likelihood_of_some(const Eigen::MatrixXd& Z, const Eigen::MatrixXd& T, int wanted,
                                      Correlation correlation) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(Z.rows()));
  std::iota(order.begin(), order.end(), 0);
  Random random{0};
  for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random.next() % (i + 1)]);
  order.resize(std::min(order.size(), static_cast<std::size_t>(wanted)));
  return {Z(order, Eigen::all), T(order, Eigen::all), correlation};
}

Eigen::VectorXd start(Eigen::Index d, double length, double noise_ratio) {
  Eigen::VectorXd log_hyper = Eigen::VectorXd::Constant(d + 1, std::log(length));
  log_hyper[d] = std::log(noise_ratio);
  return log_hyper;
}

struct MostEvident {
  GaussianProcessHyper hyper;
  double negative_log_evidence = 0;
};

MostEvident maximise_evidence(const Eigen::MatrixXd& Z, const Eigen::MatrixXd& T, Correlation correlation) {
  const double unit = std::sqrt(static_cast<double>(Z.cols()));
  const MarginalLikelihood coarse = likelihood_of_some(Z, T, kStartPoints, correlation);
  Minimum best{{}, std::numeric_limits<double>::infinity()};
  // A smooth field, a rough one, and one of which noise hides the most.
  for (const auto& [length, noise_ratio] : {std::pair{2 * unit, 0.01}, {0.5 * unit, 0.1}, {unit, 1.0}}) {
    Minimum found = minimise(coarse, start(Z.cols(), length, noise_ratio), {.tolerance = 1e-2});
    if (found.value < best.value) best = std::move(found);
  }
  const MarginalLikelihood fine = likelihood_of_some(Z, T, kRefinePoints, correlation);
  best = minimise(fine, best.x, {.tolerance = 1e-2});
  return {fine.hyper(best.x), best.value};
}

}  // namespace

std::map<std::string, double> gaussian_process_hyper(const RegressionData& data) {
  const Eigen::MatrixXd Z = FeatureScale{data.X}.apply_all(data.X);
  const Eigen::MatrixXd T = data.Y * target_scale(data.Y).cwiseInverse().asDiagonal();
  const MostEvident smooth = maximise_evidence(Z, T, Correlation::SquaredExponential);
  const MostEvident rough = maximise_evidence(Z, T, Correlation::Matern52);
  const GaussianProcessHyper& best =
      smooth.negative_log_evidence < rough.negative_log_evidence ? smooth.hyper : rough.hyper;
  std::map<std::string, double> hyper{{"matern", best.correlation == Correlation::Matern52 ? 1 : 0},
                                      {"noise_ratio", best.noise_ratio}};
  for (Eigen::Index k = 0; k < best.lengths.size(); ++k) hyper[length_name(k)] = best.lengths[k];
  return hyper;
}

RegressorPtr make_gaussian_process(const RegressorState& state) {
  return std::make_shared<GaussianProcess>(state);
}

}  // namespace truepose
