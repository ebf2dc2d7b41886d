#include "core/evaluation/chi_square.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace truepose {

double chi_square_tail(double x, int degrees) {
  assert(degrees >= 1);
  if (x <= 0) return 1;
  // Both sums run over exp(-h) h^p / Gamma(p + 1), h = x / 2: p = 0, 1, 2, .. for even degrees; for odd ones
  // p = 1/2, 3/2, .. on top of erfc(sqrt(h)). By logarithms, since exp(-h) underflows long before the sum.
  const double h = x / 2, log_h = std::log(h);
  const bool odd = degrees % 2 == 1;
  double tail = odd ? std::erfc(std::sqrt(h)) : 0;
  double log_term = odd ? (log_h - std::log(std::numbers::pi)) / 2 + std::numbers::ln2 - h : -h;
  for (double p = odd ? 0.5 : 0; p < degrees / 2.0 - 0.5; ++p) {
    tail += std::exp(log_term);
    log_term += log_h - std::log(p + 1);
  }
  return std::min(tail, 1.0);
}

}  // namespace truepose
