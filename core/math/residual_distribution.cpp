#include "core/math/residual_distribution.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kKnownBefore = 0.3;  // standard deviation of the logarithm of the mean square

}  // namespace

/// Student's law of a mean square and some degrees of freedom. With 1 / (1 + d2 / (freedom scale)) beta
/// distributed (freedom / 2, 3 / 2), the mean and the variance of its logarithm are, but for the sign, the
/// differences of the di- and trigamma functions at (freedom + 3) / 2 and freedom / 2.
struct ResidualDistribution::Tails {
  double freedom, mean, variance;

  double scale(double mean_square) const { return mean_square * (freedom - 2) / freedom; }
};

namespace {

using Tails = ResidualDistribution::Tails;

// From very heavy ones to nearly none; taken for equally likely beforehand.
constexpr std::array<Tails, 4> kTails{{{3, 0.886294361119891, 0.539868133696453},
                                       {4, 0.680372305546776, 0.314576310747991},
                                       {8, 0.354975480149951, 0.0844805687474876},
                                       {16, 0.18209639844734, 0.0221397262249324}}};

double log_likelihood(std::span<const double> validation, const Tails& tails, double mean_square) {
  const double width = tails.freedom * tails.scale(mean_square), shape = (tails.freedom + 3) / 2;
  const double most = std::lgamma(shape) - std::lgamma(tails.freedom / 2) - 1.5 * std::log(width);
  double sum = 0;
  for (const double distance2 : validation) sum += most - shape * std::log1p(distance2 / width);
  return sum;
}

/// Of all points together: the sum of the logarithms is nearly gamma distributed.
double tail_of_all(const Eigen::VectorXd& r, int degrees, double alike, const Tails& tails,
                   double mean_square) {
  const double width = tails.freedom * tails.scale(mean_square), points = degrees / 3.0;
  double sum = 0;
  for (Eigen::Index row = 0; row < r.size(); row += 3)
    sum += std::log1p(r.segment<3>(row).squaredNorm() / width);
  const double variance = alike * tails.variance;
  return gamma_tail(sum * tails.mean / variance, points * tails.mean * tails.mean / variance);
}

/// Share of the beta distribution (freedom / 2, 3 / 2) up to x.
double beta_share(double x, double freedom) {
  if (freedom == 3)
    return 2 / std::numbers::pi * (std::asin(std::sqrt(x)) - (1 - 2 * x) * std::sqrt(x * (1 - x)));
  double term = 1, sum = 0;  // freedom is even
  for (int k = 0; k < freedom / 2; ++k) {
    sum += term;
    term *= (1.5 + k) / (k + 1) * x;
  }
  return 1 - std::pow(1 - x, 1.5) * sum;
}

/// Of the worst point alone, as likely to be any of them.
double tail_of_worst(const Eigen::VectorXd& r, const Tails& tails, double mean_square) {
  double worst2 = 0;
  for (Eigen::Index row = 0; row < r.size(); row += 3)
    worst2 = std::max(worst2, r.segment<3>(row).squaredNorm());
  const double x = 1 / (1 + worst2 / (tails.freedom * tails.scale(mean_square)));
  return static_cast<double>(r.size()) / 3 * beta_share(x, tails.freedom);
}

}  // namespace

ResidualDistribution::ResidualDistribution(std::span<const double> validation) {
  constexpr double kStep = 0.05, kFrom = -1, kTo = 3, kHardly = 1e-6;
  if (validation.empty()) return;
  double best = -HUGE_VAL;
  for (const Tails& tails : kTails) {
    for (double log_value = kFrom; log_value <= kTo; log_value += kStep) {
      const double z = log_value / kKnownBefore, value = std::exp(log_value);
      candidates_.push_back({&tails, value, log_likelihood(validation, tails, value) - z * z / 2});
      best = std::max(best, candidates_.back().probability);
    }
  }
  double sum = 0;
  for (Candidate& each : candidates_) sum += each.probability = std::exp(each.probability - best);
  for (Candidate& each : candidates_) each.probability /= sum;
  std::erase_if(candidates_, [](const Candidate& each) { return each.probability < kHardly; });
}

double ResidualDistribution::tail(const Eigen::VectorXd& r, int degrees, double alike) const {
  if (candidates_.empty()) return chi_square_tail(r.squaredNorm(), degrees);
  // Two questions, of which the second, about a point that is wrong by itself, takes a tenth of the chance.
  constexpr double kOfWorst = 0.1;
  double all = 0, worst = 0;
  for (const auto& [tails, mean_square, probability] : candidates_) {
    all += probability * tail_of_all(r, degrees, alike, *tails, mean_square);
    worst += probability * tail_of_worst(r, *tails, mean_square);
  }
  return std::min({1.0, all / (1 - kOfWorst), worst / kOfWorst});
}

}  // namespace truepose
