#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/fit/least_squares_problem.hpp"
#include "core/kernels/kernels.hpp"

namespace truepose {

struct GaussNewtonOptions {
  int max_iterations = 200;
  /// Converged once the next step would change the predicted points by less than this (RMS, mm).
  double tolerance_mm = 1e-8;
};

/// Smallest dx with min |f + J dx|, columns scaled to unit norm. Minus, where the paper prints plus: f =
/// model - measured.
Eigen::VectorXd least_squares_step(const LinearSystem& system);

/// Whether a step that changes the predicted points by so much (RMS) ends a fit.
bool ends_fit(double change_mm, double rms_mm, const GaussNewtonOptions& options = {});

/// How the steps of a fit were solved.
enum class StepSolver {
  NormalEquations,  ///< by the kernels: many times faster, where no digits are lost by it
  Orthogonal,       ///< by orthogonal factors of the Jacobian
};

struct FitResult {
  CalibratedCell cell;
  int iterations = 0;
  bool converged = false;
  std::vector<double>
      rms_mm;  ///< of the whitened residuals (prior included) per point, before each iteration
  StepSolver solver = StepSolver::Orthogonal;
};

/// Fits the free parameters: Gauss-Newton with an Armijo strong-Wolfe line search.
///
/// The step is the smallest least-squares solution with columns scaled to unit norm (pseudo-inverse),
/// so columns that depend on each other do no harm. Where they do not and every whole step descends, as from
/// a coarse fit, the same steps are solved from the normal equations.
/// Source: method's paper, eqs 12 to 19 and 20 to 26.
FitResult gauss_newton(const CalibratedCell& start, const LeastSquaresProblem& problem,
                       const GaussNewtonOptions& options = {});

/// The same by one of the solvers alone.
/// @return of NormalEquations nothing where a step does not descend, or where columns depend on each other so
/// far that digits would be lost
std::optional<FitResult> gauss_newton_by(StepSolver solver, const CalibratedCell& start,
                                         const LeastSquaresProblem& problem,
                                         const GaussNewtonOptions& options = {},
                                         const kernels::Kernels& code = kernels::best());

/// Fits the free parameters by damped steps, the damping scaled by the columns' norms and steered by the
/// ratio of actual to predicted decrease. It needs no line search and tolerates dependent columns. Converged
/// as gauss_newton(). Source: Marquardt 1963; More, The Levenberg-Marquardt algorithm,
/// 1978; Nielsen, Damping parameter in Marquardt's method, 1999.
FitResult levenberg_marquardt(const CalibratedCell& start, const LeastSquaresProblem& problem,
                              const GaussNewtonOptions& options = {});

/// Fits the free parameters: gauss_newton(), and levenberg_marquardt() from where it ends without converging.
FitResult solve(const CalibratedCell& start, const LeastSquaresProblem& problem, int max_iterations);

/// Appends a fit that started where the other ended.
FitResult joined(FitResult first, FitResult then);

}  // namespace truepose
