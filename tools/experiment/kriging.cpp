#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/dense_algebra.hpp"
#include "tools/experiment/point_cloud.hpp"
#include "tools/experiment/regression_methods.hpp"

namespace truepose {
namespace {

/// Half the expected squared difference of two targets, by the distance h of their poses:
/// gamma(h) = nugget + sill (1 - rho(h / range)) for h > 0. Targets at unit scale.
struct Semivariogram {
  enum class Model { Spherical, Exponential, Gaussian };

  Model model = Model::Spherical;
  double nugget = 0;  ///< variance of the noise
  double sill = 0;    ///< variance of the field
  double range = 1;   ///< in units of the features' spread

  /// rho(h / range): 1 at 0.
  double correlation(double distance) const {
    const double h = distance / range;
    switch (model) {
      case Model::Spherical:
        return h < 1 ? 1 - 1.5 * h + 0.5 * h * h * h : 0;
      case Model::Exponential:
        return std::exp(-h);
      case Model::Gaussian:
        return std::exp(-h * h);
    }
    return 0;
  }
};

struct Pairs {
  double distance = 0, gamma = 0;  ///< means over the pairs of a bin
  double count = 0;
};

/// The closer half of all pairs, in bins of as many pairs each: far ones say nothing of how near ones are
/// alike.
std::vector<Pairs> empirical(const Eigen::MatrixXd& Z, const Eigen::MatrixXd& T,
                             const std::vector<int>& groups) {
  constexpr std::size_t kBins = 20;
  std::vector<Pairs> pairs;
  for (Eigen::Index i = 0; i < Z.rows(); ++i)
    for (Eigen::Index j = 0; j < i; ++j)
      if (groups[static_cast<std::size_t>(i)] != groups[static_cast<std::size_t>(j)])
        pairs.push_back({(Z.row(i) - Z.row(j)).norm(),
                         0.5 * (T.row(i) - T.row(j)).squaredNorm() / static_cast<double>(T.cols()), 1});
  std::ranges::sort(pairs, {}, &Pairs::distance);
  pairs.resize((pairs.size() + 1) / 2);
  std::vector<Pairs> bins(std::min(kBins, pairs.size()));
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    Pairs& bin = bins[p * bins.size() / pairs.size()];
    bin.distance += pairs[p].distance;
    bin.gamma += pairs[p].gamma;
    ++bin.count;
  }
  for (Pairs& bin : bins) {
    bin.distance /= bin.count;
    bin.gamma /= bin.count;
  }
  return bins;
}

struct Fit {
  Semivariogram variogram;
  double error = std::numeric_limits<double>::infinity();
};

/// Nugget and sill of a model of given range, neither negative: two unknowns, so the constrained optimum is
/// the free one or lies on an axis.
Fit fit_linear(Semivariogram variogram, const std::vector<Pairs>& bins) {
  const Eigen::Index B = static_cast<Eigen::Index>(bins.size());
  Eigen::MatrixX2d A(B, 2);
  Eigen::VectorXd b(B);
  for (Eigen::Index i = 0; i < B; ++i) {
    const Pairs& bin = bins[static_cast<std::size_t>(i)];
    // An estimate of gamma has a variance proportional to gamma^2 / count.
    const double weight = std::sqrt(bin.count) / std::max(bin.gamma, 1e-12);
    A.row(i) << weight, weight * (1 - variogram.correlation(bin.distance));
    b[i] = weight * bin.gamma;
  }
  const Eigen::Matrix2d N = gram(A);
  const Eigen::Vector2d r = transposed_times(A, b);
  const double determinant = N(0, 0) * N(1, 1) - N(1, 0) * N(0, 1);
  Eigen::Vector2d best{-1, -1};
  if (determinant > 1e-12 * N(0, 0) * N(1, 1)) {
    best[0] = (N(1, 1) * r[0] - N(0, 1) * r[1]) / determinant;
    best[1] = (N(0, 0) * r[1] - N(1, 0) * r[0]) / determinant;
  }
  const auto left = [&](const Eigen::Vector2d& x) {
    return (x[0] * A.col(0) + x[1] * A.col(1) - b).squaredNorm();
  };
  if (best.minCoeff() < 0) {
    const Eigen::Vector2d nugget_only{r[0] / N(0, 0), 0};
    const Eigen::Vector2d sill_only{0, N(1, 1) > 0 ? r[1] / N(1, 1) : 0};
    best = left(nugget_only) < left(sill_only) ? nugget_only : sill_only;
  }
  variogram.nugget = best[0];
  variogram.sill = best[1];
  return {variogram, left(best)};
}

/// Fits each model to the binned empirical semivariogram of all targets by weighted least squares, and keeps
/// the best. Pairs of one group are left out: they share what one group has in common.
///
/// @param Z  N x d features at unit spread
/// @param T  N x m targets at unit scale
/// @param groups  of each point
/// Source: Cressie, Fitting variogram models by weighted least squares (1985); range by search, as the model
/// is linear in the rest.
Semivariogram fit_semivariogram(const Eigen::MatrixXd& Z, const Eigen::MatrixXd& T,
                                const std::vector<int>& groups) {
  constexpr int kRanges = 40;
  const std::vector<Pairs> bins = empirical(Z, T, groups);
  if (bins.empty()) return {};
  Fit best;
  using enum Semivariogram::Model;
  for (const Semivariogram::Model model : {Spherical, Exponential, Gaussian}) {
    for (int i = 0; i < kRanges; ++i) {
      const double range = bins.back().distance * 0.1 * std::pow(40.0, i / (kRanges - 1.0));
      Fit fit = fit_linear({.model = model, .range = range}, bins);
      if (fit.error < best.error) best = fit;
    }
  }
  return best.variogram;
}

/// Covariances of the errors at all points, computed once: a prediction looks some up.
Eigen::MatrixXd covariances(const Semivariogram& variogram, const Eigen::MatrixXd& Z) {
  // The floor keeps them positive definite where poses coincide or the data are free of noise.
  const double nugget = std::max(variogram.nugget, 1e-6 * variogram.sill + 1e-12);
  Eigen::MatrixXd C(Z.rows(), Z.rows());
  for (Eigen::Index i = 0; i < Z.rows(); ++i) {
    C(i, i) = variogram.sill + nugget;
    for (Eigen::Index j = 0; j < i; ++j)
      C(i, j) = C(j, i) = variogram.sill * variogram.correlation((Z.row(i) - Z.row(j)).norm());
  }
  return C;
}

/// What the nearest points say of the field at one pose, on the stack.
class LocalKriging {
 public:
  /// @param all  covariances() of all points
  LocalKriging(const Semivariogram& variogram, const Eigen::MatrixXd& all, std::span<const Neighbour> near)
      : near_{near} {
    const Eigen::Index k = static_cast<Eigen::Index>(near.size());
    Square C(k, k);
    Column c(k);
    for (Eigen::Index i = 0; i < k; ++i) {
      c[i] = variogram.sill * variogram.correlation(near[static_cast<std::size_t>(i)].distance);
      for (Eigen::Index j = 0; j <= i; ++j) C(i, j) = all(point(i), point(j));
    }
    Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::ColMajor, kMaxNeighbours, 2> solved(k, 2);
    solved.col(0) = c;
    solved.col(1).setOnes();
    solve_positive_in_place(C, solved);
    // The multiplier of the condition that the weights sum to one: any constant is predicted exactly.
    const double multiplier = (solved.col(0).sum() - 1) / solved.col(1).sum();
    weights_ = solved.col(0) - multiplier * solved.col(1);
    variance_ = std::max(0.0, variogram.sill - weights_.dot(c) - multiplier);
  }

  void add_value(const Eigen::MatrixXd& Y, double belief, Eigen::Ref<Eigen::VectorXd> y) const {
    for (Eigen::Index i = 0; i < weights_.size(); ++i)
      y += belief * weights_[i] * Y.row(point(i)).transpose();
  }
  double variance() const { return variance_; }
  /// The part that one of the points has in the value.
  double weight_of(int wanted) const {
    for (Eigen::Index i = 0; i < weights_.size(); ++i)
      if (point(i) == wanted) return weights_[i];
    return 0;
  }

 private:
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxNeighbours, 1>;
  using Square =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxNeighbours, kMaxNeighbours>;

  Eigen::Index point(Eigen::Index i) const { return near_[static_cast<std::size_t>(i)].point; }

  std::span<const Neighbour> near_;
  Column weights_;
  double variance_ = 0;
};

class Kriging final : public Regressor {
 public:
  explicit Kriging(RegressorState of)
      : Regressor{std::move(of)},
        cloud_{state().X},
        variogram_{static_cast<Semivariogram::Model>(state().hyper.at("model")), state().hyper.at("nugget"),
                   state().hyper.at("sill"), state().hyper.at("range")},
        covariances_{covariances(variogram_, cloud_.Z())},
        neighbours_{static_cast<int>(state().hyper.at("neighbours"))} {}

  void predict(const Eigen::Ref<const Eigen::VectorXd>& x,
               Eigen::Ref<Eigen::VectorXd> y) const noexcept override {
    const Neighbours near = cloud_.nearest(cloud_.scaled(x), neighbours_);
    y.setZero();
    LocalKriging{variogram_, covariances_, near.span()}.add_value(state().Y, belief(near), y);
  }

  Eigen::VectorXd variance(const Eigen::Ref<const Eigen::VectorXd>& x) const override {
    const Neighbours near = cloud_.nearest(cloud_.scaled(x), neighbours_);
    const double believed = belief(near) * belief(near);
    const double local = LocalKriging{variogram_, covariances_, near.span()}.variance();
    return target_scale(state().Y).cwiseAbs2() * (believed * local + (1 - believed) * variogram_.sill);
  }

  Eigen::VectorXd noise() const override { return target_scale(state().Y).cwiseAbs2() * variogram_.nugget; }

  std::optional<double> freedom() const override {
    double trace = 0;
    for (int i = 0; i < cloud_.size(); ++i) {
      const Neighbours near = cloud_.nearest(cloud_.Z().row(i).transpose(), neighbours_);
      trace += LocalKriging{variogram_, covariances_, near.span()}.weight_of(i);
    }
    return trace;
  }

 private:
  double belief(const Neighbours& near) const { return cloud_.belief(near.span().front().distance); }

  PointCloud cloud_;
  Semivariogram variogram_;
  Eigen::MatrixXd covariances_;
  int neighbours_;
};

int best_neighbours(const PointCloud& cloud, const Semivariogram& variogram, const Eigen::MatrixXd& Y,
                    const std::vector<int>& groups) {
  constexpr std::array<std::size_t, 3> kNeighbours{8, 16, 32};
  const Eigen::MatrixXd all = covariances(variogram, cloud.Z());
  std::array<double, kNeighbours.size()> errors{};
  for (int i = 0; i < cloud.size(); ++i) {
    const auto elsewhere = [&](int j) {
      return groups[static_cast<std::size_t>(j)] != groups[static_cast<std::size_t>(i)];
    };
    const Neighbours near = cloud.nearest(cloud.Z().row(i).transpose(), kMaxNeighbours, elsewhere);
    for (std::size_t n = 0; n < kNeighbours.size(); ++n) {
      const auto some = near.span().first(std::min(near.span().size(), kNeighbours[n]));
      Eigen::VectorXd error = -Y.row(i).transpose();
      LocalKriging{variogram, all, some}.add_value(Y, 1, error);
      errors[n] += error.squaredNorm();
    }
  }
  return static_cast<int>(
      kNeighbours[static_cast<std::size_t>(std::ranges::min_element(errors) - errors.begin())]);
}

Hyper kriging_hyper(const RegressionData& data) {
  const PointCloud cloud{data.X};
  const std::vector<int> groups = group_numbers(data.groups, data.X.rows());
  const Eigen::MatrixXd T = data.Y * target_scale(data.Y).cwiseInverse().asDiagonal();
  const Semivariogram fitted = fit_semivariogram(cloud.Z(), T, groups);
  return {{"model", static_cast<double>(fitted.model)},
          {"nugget", fitted.nugget},
          {"sill", fitted.sill},
          {"range", fitted.range},
          {"neighbours", best_neighbours(cloud, fitted, data.Y, groups)}};
}

}  // namespace

const RegressionMethod kKriging{
    .name = "kriging",
    .fit = [](const RegressionData& data, int /*jobs*/) -> RegressorPtr {
      return std::make_shared<Kriging>(RegressorState{data.X, data.Y, kriging_hyper(data)});
    },
    .refit = [](const Hyper& hyper, const RegressionData& data) -> RegressorPtr {
      return std::make_shared<Kriging>(RegressorState{data.X, data.Y, hyper});
    }};

}  // namespace truepose
