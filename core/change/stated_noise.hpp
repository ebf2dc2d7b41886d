#pragma once

#include <Eigen/Core>

#include "core/change/time_evidence.hpp"

namespace truepose {

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

/// Whether a change leaves less than half of the standard deviation, each by its degrees of freedom.
///
/// @param squares  of the residuals, what it takes away
bool halves(double squares, Eigen::Index unknowns, const TimeEvidence& evidence);

/// Chance at which a change explains so much where nothing moved, by ChangeEvidence::chance(): a stated noise
/// that explains what is left counts like so many residuals, and seldom is a quarter more than stated. 1
/// where neither it explains that nor the change halves the standard deviation.
double chance_of(const ChangeEvidence& change, StatedNoise left, bool halved);

}  // namespace truepose
