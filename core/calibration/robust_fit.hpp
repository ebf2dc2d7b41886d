#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/calibration/gauss_newton.hpp"
#include "core/calibration/robust_loss.hpp"

namespace truepose {

/// Base and reflectors of an arm from points of which a part may be grossly wrong: the linear start on all
/// points and on random subsets, of which the one with the smallest median residual is kept, then iteratively
/// reweighted Gauss-Newton on these parameters alone.
///
/// Deterministic. Source: method's description, section "gross errors", steps 1 and 2.
/// @param points  at least five poses
CalibratedCell robust_start(const RobotModel& arm, std::span<const std::string> smr_names,
                            std::span<const Measurement> points, std::span<const Eigen::Matrix3d> W);

/// The weight of every point once all parameters are fitted by reweighting: a redescending loss, its scale
/// from the median residual and frozen before the end, with a wide prior on the links so that no weak
/// geometry lets it run away.
///
/// Source: same, step 3.
/// @param problem  without prior
/// @param sigma_mm  out: standard deviation of one coordinate of a whitened residual of the good points
struct RobustFit {
  CalibratedCell cell;
  double sigma_mm = 0;  ///< of one coordinate of a good point's whitened residual
};
RobustFit robust_fit(const CalibratedCell& start, const LeastSquaresProblem& problem);

/// Weight of each point under `loss`, from its whitened residual at `cell`. Beyond `sigma` times five (IGG3:
/// six) a point has weight 0; Huber keeps every point.
std::vector<double> point_weights(const CalibratedCell& cell, std::span<const Measurement> points,
                                  std::span<const Eigen::Matrix3d> W, Loss loss, double sigma_mm);

}  // namespace truepose
