#pragma once

#include "core/data/calibrated_cell.hpp"
#include "core/fit/least_squares_problem.hpp"

namespace truepose {

/// Standard deviations with which the parameters of a real arm scatter about its data sheet, and reflectors
/// about its flange.
struct PriorScale {
  double length_mm = 0.3;  ///< a, d; coefficient of a deviation term that moves along, per unit of its basis
  double angle_rad = 0.3e-3;  ///< alpha, theta, beta
  double reflector_mm = 300;  ///< from the flange's centre: what keeps a reflector near that no pose shows
  double deviation = 0.3e-3;  ///< coefficient of one that turns, rad per unit of its basis

  bool operator==(const PriorScale&) const = default;
};

/// The prior around `nominal` that knows nothing of the base, and of the reflectors that they are on a tool.
///
/// @param sigma_mm  standard deviation of one coordinate of a whitened residual
Prior prior_of(const CalibratedCell& nominal, const PriorScale& scale, double sigma_mm);

}  // namespace truepose
