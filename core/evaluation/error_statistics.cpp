#include "core/evaluation/error_statistics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

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

}  // namespace truepose
