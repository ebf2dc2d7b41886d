#pragma once

#include "core/fit/least_squares_problem.hpp"

namespace truepose {

/// How many times farther points are than a fit predicts them from others that lie on one side of them: of
/// each joint, the points of its lowest and of its highest third are predicted from all others.
///
/// A model that describes the arm gives 1. One that does not is, where nothing was measured, worse by about
/// as much as here: what it leaves is no noise, which is the same everywhere.
/// @param system  of the problem, at its solution
/// @return at least 1; 1 where the others do not determine the fit
double left_out_sides_factor(const LeastSquaresProblem& problem, const LinearSystem& system);

}  // namespace truepose
