#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/fit/normal_equations.hpp"

namespace truepose {

/// Whole Gauss-Newton steps on prepared points by Cholesky's factorisation of the normal equations at unit
/// column norm, with room reused from one to the next.
class WholeSteps {
 public:
  /// @param start    of the structure that will be moved
  /// @param points   prepared for its arm, under the weights of the problem; kept by reference like `problem`
  WholeSteps(const CalibratedCell& start, PreparedPoints& points, const LeastSquaresProblem& problem);

  /// Whether there are few enough parameters for it.
  static bool possible(const CalibratedCell& start, const LeastSquaresProblem& problem);

  /// Looks at the points from `cell`. Allocates for a prior alone.
  void evaluate(const CalibratedCell& cell);
  /// Of the whitened residuals there, prior included, per point.
  double rms_mm() const;
  /// Moves `cell`, where it was evaluated, by the step. Does not allocate.
  /// @return by how much that changes the predicted points (RMS, mm); nothing where columns depend on each
  /// other so far that digits would be lost, and the cell stays
  std::optional<double> advance(CalibratedCell& cell);

 private:
  bool solve();

  const PreparedPoints& points_;
  const std::vector<int>& free_;
  NormalEquations equations_;
  int size_, stride_;
  std::vector<kernels::Line> lines_;
  Eigen::VectorXd scale_, step_, direction_;
};

/// Whether a step leads down, or not so far up that rounding could not have done it.
/// @param before_mm, after_mm  rms_mm() at its ends
bool descends(double before_mm, double after_mm);

}  // namespace truepose
