#include "core/math/statistics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace truepose {
namespace {

AxisStatistics axis_statistics(std::span<const Eigen::Vector3d> errors, int axis) {
  AxisStatistics s;
  for (const Eigen::Vector3d& e : errors) {
    s.mean_abs += std::abs(e[axis]);
    s.rms += e[axis] * e[axis];
    s.max_abs = std::max(s.max_abs, std::abs(e[axis]));
  }
  const auto n = static_cast<double>(errors.size());
  s.mean_abs /= n;
  s.rms = std::sqrt(s.rms / n);
  return s;
}

}  // namespace

ErrorStatistics error_statistics(std::span<const Eigen::Vector3d> errors) {
  assert(!errors.empty());
  ErrorStatistics s;
  s.count = static_cast<int>(errors.size());
  s.min = errors.front().norm();
  for (const Eigen::Vector3d& e : errors) {
    s.mean += e.norm();
    s.rms += e.squaredNorm();
    s.max = std::max(s.max, e.norm());
    s.min = std::min(s.min, e.norm());
  }
  const auto n = static_cast<double>(errors.size());
  s.mean /= n;
  s.rms = std::sqrt(s.rms / n);
  if (errors.size() > 1) {
    double squares = 0;
    for (const Eigen::Vector3d& e : errors) squares += (e.norm() - s.mean) * (e.norm() - s.mean);
    s.std = std::sqrt(squares / (n - 1));
  }
  s.x = axis_statistics(errors, 0);
  s.y = axis_statistics(errors, 1);
  s.z = axis_statistics(errors, 2);
  return s;
}

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
