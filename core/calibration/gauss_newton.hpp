#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/calibration/calibrated_cell.hpp"
#include "core/calibration/measurement.hpp"

namespace truepose {

struct GaussNewtonOptions {
  int max_iterations = 200;
  /// Converged once the next step would change the predicted points by less than this (RMS, mm).
  double tolerance_mm = 1e-8;
};

struct GaussNewtonResult {
  CalibratedCell cell;
  int iterations = 0;
  bool converged = false;
};

/// Fits the parameters in `free` (indices of ParameterLayout) to the points, all others held: Gauss-Newton
/// with an Armijo strong-Wolfe line search.
///
/// The step is the smallest least-squares solution with columns scaled to unit norm (pseudo-inverse by SVD),
/// so columns that depend on each other do no harm.
/// @param weights  of each point (1 / sigma, relative); empty = all alike
/// Source: method's paper, eqs 12 to 19 and 20 to 26.
GaussNewtonResult gauss_newton(const CalibratedCell& start, std::span<const Measurement> points,
                               const std::vector<int>& free, const Eigen::VectorXd& weights,
                               const GaussNewtonOptions& options = {});

/// The columns `free` of the weighted Jacobian of all points, and the weighted residuals.
struct LinearSystem {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
};
LinearSystem linearise(const CalibratedCell& cell, std::span<const Measurement> points,
                       const std::vector<int>& free, const Eigen::VectorXd& weights);

}  // namespace truepose
