#pragma once

#include <Eigen/Core>

#include "core/judge/time_evidence.hpp"

namespace truepose {

/// Whether the stated noise explains residuals: along the beams, and across them.
///
/// @param unknowns  of the columns beside the parameters that these residuals are left by
bool noise_explains(const TimeEvidence& evidence, const Eigen::VectorXd& left, Eigen::Index unknowns);

/// Of the squares of the residuals, what further columns take away, and whether they leave what the stated
/// noise explains.
struct Gain {
  double squares = 0;
  Eigen::Index unknowns = 0;
  bool as_stated = false;
};

/// Of the squares of the residuals, what it leaves.
double squares_left(const Gain& gain, const TimeEvidence& evidence);

/// Whether less than half of the standard deviation is left, each by its degrees of freedom.
bool halves(const Gain& gain, const TimeEvidence& evidence);

/// Chance at which columns explain so much where nothing moved: by a beta distribution, whatever the scale of
/// the noise, but that a stated one which explains what is left counts like so many residuals. 1 where
/// neither it explains that nor the columns halve the standard deviation.
double chance_of(const Gain& gain, const TimeEvidence& evidence);

}  // namespace truepose
