#pragma once

#include "core/calibration/gauss_newton.hpp"

namespace truepose {

/// Fits the free parameters by damped steps, the damping scaled by the columns' norms and steered by the
/// ratio of actual to predicted decrease. For comparison: it needs no line search and tolerates dependent
/// columns. Converged as gauss_newton(). Source: Marquardt 1963; More, The Levenberg-Marquardt algorithm,
/// 1978; Nielsen, Damping parameter in Marquardt's method, 1999.
FitResult levenberg_marquardt(const CalibratedCell& start, const LeastSquaresProblem& problem,
                              const GaussNewtonOptions& options = {});

}  // namespace truepose
