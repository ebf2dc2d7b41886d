#include "core/math/statistics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

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

namespace {

constexpr double kDone = 1e-15;

/// The share of the distribution up to x, over the factor of tail and share: a sum of positive terms.
double share_by_series(double x, double shape) {
  double term = 1 / shape, sum = term;
  for (double n = shape + 1; term > kDone * sum; ++n) {
    term *= x / n;
    sum += term;
  }
  return sum;
}

/// The tail, over the same factor.
double tail_by_fraction(double x, double shape) {
  double b = x + 1 - shape, c = HUGE_VAL, d = 1 / b, fraction = d, ratio = 0;
  for (double n = 1; std::abs(ratio - 1) > kDone; ++n) {
    const double a = -n * (n - shape);
    b += 2;
    d = 1 / (a * d + b);
    c = b + a / c;
    fraction *= ratio = c * d;
  }
  return fraction;
}

}  // namespace

double standard_errors_gained(std::span<const double> before, std::span<const double> after) {
  assert(before.size() == after.size() && before.size() > 1);
  const auto n = static_cast<double>(before.size());
  const Eigen::Map<const Eigen::ArrayXd> b(before.data(), std::ssize(before)),
      a(after.data(), std::ssize(after));
  const Eigen::ArrayXd fall = b - a;
  const double mean = fall.mean(), variance = (fall - mean).square().sum() / (n - 1);
  if (variance > 0) return mean / std::sqrt(variance / n);
  return mean == 0 ? 0 : std::copysign(HUGE_VAL, mean);
}

double gamma_tail(double x, double shape) {
  assert(shape > 0);
  if (x <= 0) return 1;
  // By logarithms, since exp(-x) underflows long before the tail.
  const double factor = std::exp(shape * std::log(x) - x - std::lgamma(shape));
  return x < shape + 1 ? 1 - factor * share_by_series(x, shape) : factor * tail_by_fraction(x, shape);
}

}  // namespace truepose
