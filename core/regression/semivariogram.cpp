#include "core/regression/semivariogram.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/linear_algebra/products.hpp"

namespace truepose {
namespace {

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

}  // namespace

double Semivariogram::correlation(double distance) const {
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

}  // namespace truepose
