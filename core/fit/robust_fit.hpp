#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/choices.hpp"
#include "core/fit/least_squares_solver.hpp"

namespace truepose {

/// Whether a fit under this loss reweights its points at each iteration.
constexpr bool reweighs(Loss loss) { return loss != Loss::OutlierRejection && loss != Loss::Squared; }

/// Weight in [0, 1] of a point whose whitened residual is `length` long (three coordinates, in units of the
/// standard deviation of one).
double huber_weight(double length, double knee);
double igg3_weight(double length, double knee, double cut);
double tukey_weight(double length, double cut);

/// Standard deviation of one coordinate from the median length of three-dimensional residuals: half of all
/// may be wrong. Source: the median of the chi distribution with three degrees of freedom is 1.538.
double sigma_from_median(std::span<const double> lengths);

/// Base and reflectors of an arm from points of which a part may be grossly wrong: placement() from all
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

/// Weight of each point under `loss`, from its whitened residual at `cell`, or from the turn of its target
/// where that is longer. Beyond `sigma` times five (IGG3: six) a point has weight 0; Huber keeps every point.
///
/// @param whitened  points and whitening alone
/// @param present   the weights that they have
std::vector<double> point_weights(const CalibratedCell& cell, const LeastSquaresProblem& whitened,
                                  std::span<const double> present, Loss loss, double sigma_mm);

}  // namespace truepose
