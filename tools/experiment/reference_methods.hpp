#pragma once

#include "core/data/measurement.hpp"
#include "core/fit/least_squares_solver.hpp"

namespace truepose {

/// Methods of the paper's references: base and reflectors first, the arm held at nominal, then every
/// parameter at once, the nearest among equal fits.
enum class ReferenceMethod {
  LeastSquares,        ///< Gauss-Newton by the pseudo-inverse, with a line search
  GaussNewton,         ///< the same, every step taken whole
  LevenbergMarquardt,  ///< damped
  Ridge,               ///< shrunk towards the data sheet; how much, by generalised cross-validation
};

struct ReferenceFit {
  FitResult coarse, fine;
};

/// Fits by one of them.
/// @param start  nominal arm with a guess of base and reflectors
/// @param data   of one station, points alike in weight
ReferenceFit fit_by(ReferenceMethod method, const CalibratedCell& start, const MeasurementData& data);

/// Gauss-Newton with every step taken whole, by the pseudo-inverse: what a line search is compared with.
FitResult gauss_newton_in_whole_steps(const CalibratedCell& start, const LeastSquaresProblem& problem,
                                      int max_iterations);

}  // namespace truepose
