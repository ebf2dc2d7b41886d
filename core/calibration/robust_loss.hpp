#pragma once

#include <span>
#include <vector>

namespace truepose {

/// How much a large residual counts.
enum class Loss {
  Squared,  ///< as it stands: right where there are no gross errors
  Huber,    ///< linearly beyond a few sigma: every point stays in
  Igg3,   ///< less and less, and not at all beyond 6 sigma (Yang's third scheme of the Institute of Geodesy)
  Tukey,  ///< not at all beyond a few sigma, nor its sway near there
};

/// Weight in [0, 1] of a point whose whitened residual is `length` long (three coordinates, in units of the
/// standard deviation of one).
double huber_weight(double length, double knee);
double igg3_weight(double length, double knee, double cut);
double tukey_weight(double length, double cut);

/// Standard deviation of one coordinate from the median length of three-dimensional residuals: half of all
/// may be wrong. Source: the median of the chi distribution with three degrees of freedom is 1.538.
double sigma_from_median(std::span<const double> lengths);

}  // namespace truepose
