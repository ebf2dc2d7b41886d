#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/calibration/gauss_newton.hpp"
#include "core/kernels/kernels.hpp"
#include "core/kernels/prepared_points.hpp"

namespace truepose {

/// J'WJ, J'Wf and f'Wf of the residuals f (predicted minus measured, mm) in the order of the free parameters,
/// W = diag(weight^2).
struct NormalEquations {
  Eigen::MatrixXd A;
  Eigen::VectorXd g;
  double cost = 0;
};

/// The normal equations of the parameters `free` (indices of ParameterLayout, ascending): what linearise()
/// says, without ever holding the Jacobian.
NormalEquations normal_equations(const CalibratedCell& cell, const PreparedPoints& points,
                                 const std::vector<int>& free);

/// The same fit as gauss_newton() where the problem is benign: full steps by Cholesky's factorisation at unit
/// column norm, the same end. Does not allocate inside an iteration.
///
/// @param start   the cell whose arm `points` was prepared for
/// @param free    indices of ParameterLayout, ascending
/// @return nothing where a step does not descend, or where the columns depend on each other so far that
/// normal equations would lose digits: gauss_newton() then has the answer.
std::optional<GaussNewtonResult> fast_gauss_newton(const CalibratedCell& start, const PreparedPoints& points,
                                                   const std::vector<int>& free,
                                                   const GaussNewtonOptions& options = {});

}  // namespace truepose
