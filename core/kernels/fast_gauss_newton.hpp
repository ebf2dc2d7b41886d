#pragma once

#include <optional>
#include <vector>

#include "core/calibration/gauss_newton.hpp"
#include "core/kernels/prepared_points.hpp"

namespace truepose {

/// The same fit as gauss_newton() where the problem is benign: full steps by Cholesky's factorisation of the
/// normal equations at unit column norm, ending by the same rule. Does not allocate inside an iteration.
///
/// @param start   the cell for whose arm `points` was prepared
/// @param free    indices of ParameterLayout, ascending
/// @return nothing where a step does not descend, or where the columns depend on each other so far that
/// normal equations would lose digits: gauss_newton() then has the answer
std::optional<FitResult> fast_gauss_newton(const CalibratedCell& start, const PreparedPoints& points,
                                           const std::vector<int>& free,
                                           const GaussNewtonOptions& options = {});

}  // namespace truepose
