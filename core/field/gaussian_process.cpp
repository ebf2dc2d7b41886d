#include "core/field/gaussian_process.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/field/scaled_points.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/lbfgs.hpp"
#include "core/math/parallel.hpp"
#include "core/math/random.hpp"

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

/// @param C  correlations of all points
CholeskyFactor with_noise(Eigen::MatrixXd C, double noise_ratio) {
  C.diagonal().setConstant(1 + noise_ratio);
  CholeskyFactor factor{C};
  for (double jitter = 1e-10; !factor.succeeded() && jitter < 1; jitter *= 10) {
    C.diagonal().setConstant(1 + noise_ratio + jitter);
    factor = CholeskyFactor{C};
  }
  return factor;
}

}  // namespace

CholeskyFactor factorise(const Eigen::MatrixXd& Z, const GaussianProcessHyper& hyper) {
  const Eigen::MatrixXd scaled = Z * hyper.lengths.cwiseInverse().asDiagonal();
  return with_noise(correlation_of(hyper.correlation, squared_distances(scaled, scaled)).matrix(),
                    hyper.noise_ratio);
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
  const Eigen::MatrixXd scaled = Z_ * at.lengths.cwiseInverse().asDiagonal();
  const Eigen::ArrayXXd u = squared_distances(scaled, scaled), C = correlation_of(correlation_, u);
  const CholeskyFactor factor = with_noise(C, at.noise_ratio);
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
  const Eigen::MatrixXd A = (W.array() * correlation_slope(correlation_, u, C)).matrix();
  const Eigen::VectorXd row_sums = A.rowwise().sum();
  gradient.head(d) = -2 * (transposed_times(scaled.cwiseAbs2(), row_sums) -
                           scaled.cwiseProduct(times(A, scaled)).colwise().sum().transpose());
  return value + prior(log_hyper, gradient);
}

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
  explicit GaussianProcess(RegressorState of)
      : Regressor{std::move(of)},
        hyper_{hyper_of(state())},
        scale_{state().X},
        factor_{factorise(scale_.apply_all(state().X), hyper_)},
        points_{scale_.apply_all(state().X) * hyper_.lengths.cwiseInverse().asDiagonal()},
        alpha_{Eigen::MatrixXd::Zero(points_.blocks() * kBlock, state().Y.cols())} {
    const Eigen::MatrixXd& Y = state().Y;
    alpha_.topRows(Y.rows()) = factor_.solve(Y);
    signal_ = Y.cwiseProduct(alpha_.topRows(Y.rows())).colwise().mean();
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

  Eigen::VectorXd variance(const Eigen::Ref<const Eigen::VectorXd>& x) const override {
    const Features z = scaled(x);
    Eigen::VectorXd r(alpha_.rows());
    for (int b = 0; b < points_.blocks(); ++b)
      r.segment<kBlock>(b * kBlock) = correlation_of(hyper_.correlation, points_.squared_distances(z, b));
    const double known = factor_.solve_lower(r.head(state().Y.rows())).squaredNorm();
    return signal_ * std::max(0.0, 1 - known);
  }

  Eigen::VectorXd noise() const override { return hyper_.noise_ratio * signal_; }

  std::optional<double> freedom() const override {
    // R (R + r I)^-1 = I - r (R + r I)^-1.
    return static_cast<double>(state().X.rows()) - hyper_.noise_ratio * factor_.inverse_lower().squaredNorm();
  }

 private:
  static constexpr int kBlock = BlockedPoints::kBlock;

  Features scaled(const Eigen::Ref<const Eigen::VectorXd>& x) const {
    return scale_.apply(x).cwiseQuotient(hyper_.lengths);
  }

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

Hyper most_evident_hyper(const RegressionData& data, int jobs) {
  const Eigen::MatrixXd Z = FeatureScale{data.X}.apply_all(data.X);
  const Eigen::MatrixXd T = data.Y * target_scale(data.Y).cwiseInverse().asDiagonal();
  constexpr std::array kCorrelations{Correlation::Matern52, Correlation::SquaredExponential};
  std::array<MostEvident, kCorrelations.size()> found;
  parallel_for(static_cast<int>(found.size()), jobs, [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    found[k] = maximise_evidence(Z, T, kCorrelations[k]);
  });
  const GaussianProcessHyper& best =
      std::ranges::min_element(found, {}, &MostEvident::negative_log_evidence)->hyper;
  Hyper hyper{{"matern", best.correlation == Correlation::Matern52 ? 1 : 0},
              {"noise_ratio", best.noise_ratio}};
  for (Eigen::Index k = 0; k < best.lengths.size(); ++k) hyper[length_name(k)] = best.lengths[k];
  return hyper;
}

/// What of the hyper-parameters is missing or out of its range.
std::optional<std::string> fault_of(const Hyper& hyper, Eigen::Index features) {
  constexpr double kHuge = std::numeric_limits<double>::max(), kTiny = std::numeric_limits<double>::min();
  const auto fault = [&](const std::string& name, double low, double high) -> std::optional<std::string> {
    const auto found = hyper.find(name);
    const std::string place = "residual field gp: hyper-parameter " + name;
    if (found == hyper.end()) return place + " is missing";
    if (!(found->second >= low && found->second <= high)) return place + " is out of its range";
    return std::nullopt;
  };
  if (auto of = fault("matern", 0, 1)) return of;
  if (auto of = fault("noise_ratio", 0, kHuge)) return of;
  for (Eigen::Index k = 0; k < features; ++k)
    if (auto of = fault(length_name(k), kTiny, kHuge)) return of;
  return std::nullopt;
}

}  // namespace

const RegressionMethod kGaussianProcess{
    .name = "gp",
    .fit = [](const RegressionData& data, int jobs) -> RegressorPtr {
      return std::make_shared<GaussianProcess>(
          RegressorState{data.X, data.Y, most_evident_hyper(data, jobs)});
    },
    .refit = [](const Hyper& hyper, const RegressionData& data) -> RegressorPtr {
      return std::make_shared<GaussianProcess>(RegressorState{data.X, data.Y, hyper});
    }};

std::expected<RegressorPtr, std::string> restore_gaussian_process(const RegressorState& state) {
  if (auto fault = fault_of(RegressionData{state.X, state.Y, {}})) return std::unexpected{*fault};
  if (auto fault = fault_of(state.hyper, state.X.cols())) return std::unexpected{*fault};
  return std::make_shared<GaussianProcess>(state);
}

}  // namespace truepose
