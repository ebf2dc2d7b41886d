#pragma once

#include <Eigen/Core>

#include "core/change/time_evidence.hpp"

namespace truepose {

/// Residuals that a stated noise counts as: it is known to a quarter.
inline constexpr double kStatedCounts = 10;

/// What the stated noise says of residuals.
enum class StatedNoise {
  Explains,
  NearlyExplains,  ///< were it a quarter more
  Contradicts,     ///< or none was stated
};

/// Of residuals along the beams, and across them.
///
/// @param unknowns  number of columns, in addition to the parameters, of the fit that leaves these residuals
StatedNoise stated_noise(const TimeEvidence& evidence, const Eigen::VectorXd& left, Eigen::Index unknowns);

/// Of the squares of the residuals, what further columns take away.
struct Gain {
  double squares = 0;
  Eigen::Index unknowns = 0;
  StatedNoise noise = StatedNoise::Contradicts;  ///< of what is left
};

/// Of the squares of the residuals, what it leaves.
double squares_left(const Gain& gain, const TimeEvidence& evidence);

/// Whether less than half of the standard deviation is left, each by its degrees of freedom.
bool halves(const Gain& gain, const TimeEvidence& evidence);

/// Chance at which columns explain so much where nothing moved: by a beta distribution, whatever the scale of
/// the noise, but that a stated one which explains what is left counts like so many residuals, and that it
/// seldom is a quarter more than stated. 1 where neither it explains that nor the columns halve the standard
/// deviation.
double chance_of(const Gain& gain, const TimeEvidence& evidence);

}  // namespace truepose
