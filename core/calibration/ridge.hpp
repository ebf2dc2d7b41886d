#pragma once

#include "core/calibration/least_squares_problem.hpp"
#include "core/calibration/prior.hpp"

namespace truepose {

/// The prior whose strength generalised cross-validation chooses in the problem linearised at `cell`.
///
/// Source: Golub, Heath, Wahba, Generalized cross-validation as a method for choosing a good ridge parameter,
/// 1979.
Prior ridge_prior(const CalibratedCell& cell, const LeastSquaresProblem& problem, const PriorScale& scale);

}  // namespace truepose
