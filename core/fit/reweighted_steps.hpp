#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/fit/least_squares_problem.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/prepared_points.hpp"

namespace truepose {

/// Gauss-Newton steps on points whose weights change with every step, as a robust fit takes them. The points
/// are prepared once, and looked at once a step.
class ReweightedSteps {
 public:
  /// @param problem  with the points' whitening; must outlive it
  ReweightedSteps(CalibratedCell start, const LeastSquaresProblem& problem);

  const CalibratedCell& cell() const { return cell_; }
  /// Lengths (mm) of the points' whitened residuals at the cell.
  const std::vector<double>& lengths_mm() const { return lengths_mm_; }
  /// Moves the cell as one iteration of gauss_newton() does.
  void step(std::span<const double> weights, const Prior& prior);

 private:
  bool step_whole(std::span<const double> weights);
  double rms_mm(std::span<const double> lengths_mm, std::span<const double> weights,
                const CalibratedCell& cell) const;

  std::vector<double> lengths_at(const CalibratedCell& cell) const;

  CalibratedCell cell_;
  const LeastSquaresProblem& whitened_;
  LeastSquaresProblem weighted_;
  std::vector<double> weights_;
  RepeatedResiduals residuals_;
  PreparedPoints points_;
  std::vector<double> lengths_mm_;
};

/// Lengths (mm) of residuals, three coordinates each, once whitened.
/// @param W  of each; empty = identity
std::vector<double> whitened_lengths(const Eigen::VectorXd& residuals, std::span<const Eigen::Matrix3d> W);

/// The same of the points of a problem, or that of the turn of its target where it is longer.
/// @param residuals  of the points at the cell
/// @param whitened   the problem without weights
/// @param weights    of the points, by which they count for the mounting of a target
std::vector<double> whitened_lengths(const Eigen::VectorXd& residuals, const CalibratedCell& cell,
                                     const LeastSquaresProblem& whitened, std::span<const double> weights);

}  // namespace truepose
