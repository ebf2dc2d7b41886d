#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// Gaussian knowledge of parameters from before the measurement, in the order of ParameterLayout.
struct Prior {
  Eigen::VectorXd centre;  ///< expected values, mm and rad
  Eigen::VectorXd
      weight;  ///< expected residual (mm) over standard deviation of the parameter; 0 = nothing known
  double sigma_mm =
      0;  ///< that residual where it is the noise itself; 0: the noise is estimated from what is left
};

/// What to fit: some parameters of a cell to measured points.
struct LeastSquaresProblem {
  std::span<const Measurement> points;
  std::vector<int> free;           ///< indices of ParameterLayout; all others are held
  std::vector<Eigen::Matrix3d> W;  ///< multiplies each point's residual; empty = identity
  /// Multiplies the turn (rad) of each point's orientation, to mm; empty = no orientation counts.
  std::vector<double> turn_weight{};
  Prior prior;  ///< empty vectors = none
};

/// Whitened residuals (predicted minus measured) and their derivative to the free parameters: 3 rows a point,
/// then 3 for each orientation that counts, then one for each free parameter of which the prior knows
/// something.
struct LinearSystem {
  Eigen::VectorXd f;
  Eigen::MatrixXd J;
  int mountings = 0;  ///< equations that the unknown mountings of 6-D targets take up
};
LinearSystem linearise(const CalibratedCell& cell, const LeastSquaresProblem& problem);

/// The rows that are of each point of a problem: of its position, and of its target's turn where that counts.
std::vector<std::vector<int>> rows_of_points(const LeastSquaresProblem& problem);

/// Appends the prior's rows to those of points, for the free parameters.
void append_prior(LinearSystem& system, const CalibratedCell& cell, const LeastSquaresProblem& problem);

/// `step` of the free parameters as one of all (layout order).
Eigen::VectorXd scattered(const Eigen::VectorXd& step, const std::vector<int>& free, int size);

}  // namespace truepose
