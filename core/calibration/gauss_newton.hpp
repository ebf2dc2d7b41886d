#pragma once

#include <vector>

#include "core/calibration/least_squares_problem.hpp"

namespace truepose {

struct GaussNewtonOptions {
  int max_iterations = 200;
  /// Converged once the next step would change the predicted points by less than this (RMS, mm).
  double tolerance_mm = 1e-8;
  bool line_search = true;  ///< false: every step is taken whole (for comparison)
};

struct FitResult {
  CalibratedCell cell;
  int iterations = 0;
  bool converged = false;
  std::vector<double>
      rms_mm;  ///< of the whitened residuals (prior included) per point, before each iteration
};

/// Fits the free parameters: Gauss-Newton with an Armijo strong-Wolfe line search.
///
/// The step is the smallest least-squares solution with columns scaled to unit norm (pseudo-inverse),
/// so columns that depend on each other do no harm.
/// Source: method's paper, eqs 12 to 19 and 20 to 26.
FitResult gauss_newton(const CalibratedCell& start, const LeastSquaresProblem& problem,
                       const GaussNewtonOptions& options = {});

}  // namespace truepose
