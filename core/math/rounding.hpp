#pragma once

#include <cmath>

namespace truepose {

/// A number of a data sheet again after conversions: the multiple of 1e-6 that `value` misses by less than
/// 1e-11, otherwise `value`.
inline double without_rounding(double value) {
  constexpr double kPerStep = 1e6, kNoise = 1e-11;
  const double nearest = std::round(value * kPerStep) / kPerStep;
  return std::abs(value - nearest) < kNoise ? nearest + 0.0 : value;
}

}  // namespace truepose
