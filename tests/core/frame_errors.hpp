#pragma once

#include <Eigen/Core>
#include <numeric>
#include <vector>

#include "core/math/random.hpp"

namespace truepose {

/// Of a standard deviation `sigma` along each axis.
inline Eigen::Vector3d normal(Random& random, double sigma) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return sigma * Eigen::Vector3d(x, y, z);
}

inline double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace truepose
