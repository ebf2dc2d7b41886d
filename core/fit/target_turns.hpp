#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/fit/least_squares_problem.hpp"

namespace truepose {

// Orientations of 6-D targets in an identification. How a target is turned on the flange (R_FT) is as unknown
// as where it is. It has no parameters: under any cell the mounting that suits the readings best is a mean,
// so that the rows of a fit are turns less their mean, and the fit is the same as one with the mounting free.

/// How a 6-D target is mounted on the flange.
struct Mounting {
  Eigen::Matrix3d R_FT = Eigen::Matrix3d::Identity();
  double sigma_rad = 0;  ///< of a turn about each axis, root mean square
};

/// The points that have an orientation, in their order.
std::vector<std::size_t> oriented_points(std::span<const Measurement> points);

/// Whitened weights of orientations: mm per rad, `finest_mm` over each sigma; 0 of points without one. Empty
/// where no point has one.
///
/// @param finest_mm  to which the positions are whitened
std::vector<double> turn_weights(std::span<const Measurement> points, double finest_mm);

/// The mounting of each reflector that suits its readings best, without a sigma; nothing of one without
/// readings.
///
/// @param weight  of each point's turn; empty: by its sigma
std::vector<std::optional<Eigen::Matrix3d>> best_mountings(const CalibratedCell& cell,
                                                           std::span<const Measurement> points,
                                                           std::span<const double> weight = {});

/// How far each point's target is turned from where the cell has it (predicted minus measured, rad, about the
/// axes of the flange); zero where it has no orientation.
///
/// @param R_FT  of each reflector; a target of another turns as the identity
std::vector<Eigen::Vector3d> target_turns(const CalibratedCell& cell, std::span<const Measurement> points,
                                          std::span<const std::optional<Eigen::Matrix3d>> R_FT);

/// Lengths of the points' turns, whitened (mm); 0 where none counts.
///
/// @param weight  turn_weights()
/// @param trust   of each point, by which it counts for the mounting; empty: all alike
std::vector<double> whitened_turns(const CalibratedCell& cell, std::span<const Measurement> points,
                                   std::span<const double> weight, std::span<const double> trust = {});

/// Lengths of the points' turns in standard deviations of one axis: of their reading, and of what the
/// parameters leave open of the flange's turn; 0 where there is no orientation.
///
/// @param R_FT        of each reflector
/// @param covariance  of the parameters, in the order of ParameterLayout
/// @param factor      of the readings' scatter to their stated sigma
std::vector<double> turn_sigmas(const CalibratedCell& cell, std::span<const Measurement> points,
                                std::span<const std::optional<Eigen::Matrix3d>> R_FT,
                                const Eigen::MatrixXd& covariance, double factor);

/// Why turns of so much are not those of an arm that errs, but of angles of another frame, unit or order;
/// empty where they may be.
std::string reason_not_an_arm(std::span<const double> turn_rad);

/// Appends the rows of the orientations of a problem: of each point of oriented_points(), where any weight is
/// given, its turn less the mean of its reflector's, times its weight.
void append_turns(LinearSystem& system, const CalibratedCell& cell, const LeastSquaresProblem& problem);

/// The mountings under a fitted cell, with what its parameters and the readings leave open.
///
/// @param covariance  of the parameters, in the order of ParameterLayout
/// @param scale       of the readings' scatter to their stated sigma
std::vector<std::optional<Mounting>> mountings(const CalibratedCell& cell,
                                               std::span<const Measurement> points,
                                               const Eigen::MatrixXd& covariance, double scale);

}  // namespace truepose
