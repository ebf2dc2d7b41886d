#include "core/math/f_distribution.hpp"

#include <cassert>
#include <cmath>

namespace truepose {
namespace {

/// The share of the beta distribution (a, b) up to x, by a continued fraction that converges within about the
/// root of a or b terms where x is below the middle.
double beta_share(double x, double a, double b) {
  constexpr double kNegligible = 1e-15;
  const double factor = std::exp(a * std::log(x) + b * std::log1p(-x) + std::lgamma(a + b) -
                                 std::lgamma(a + 1) - std::lgamma(b));
  double c = 1, d = 1 / (1 - x * (a + b) / (a + 1)), fraction = d, ratio = 0;
  const auto take = [&](double numerator) {
    d = 1 / (1 + numerator * d);
    c = 1 + numerator / c;
    fraction *= ratio = c * d;
  };
  for (double m = 1; std::abs(ratio - 1) > kNegligible; ++m) {
    take(m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)));
    take(-(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)));
  }
  return factor * fraction;
}

}  // namespace

double f_tail(double x, double above, double below) {
  assert(above > 0 && below > 0);
  if (x <= 0) return 1;
  const double a = below / 2, b = above / 2, share = below / (below + above * x);
  if (share < (a + 1) / (a + b + 2)) return beta_share(share, a, b);
  return 1 - beta_share(above * x / (below + above * x), b, a);
}

}  // namespace truepose
