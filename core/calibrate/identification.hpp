#pragma once

#include <optional>
#include <vector>

#include "core/calibrate/calibrate.hpp"
#include "core/fit/least_squares_solver.hpp"
#include "core/fit/weighted_points.hpp"

namespace truepose {

/// One identification: what each of its stages leaves for the next. May be moved, but not copied: its problem
/// points into its points.
struct Identification {
  Identification(RobotModel arm, MeasurementData measured, CalibrateOptions wanted);

  RobotModel nominal;
  MeasurementData data;
  CalibrateOptions options;
  WeightedPoints points;  ///< those to identify
  LeastSquaresProblem problem;
  std::vector<int> identified;  ///< independent parameters of the geometry
  FitResult fit;
  ParameterUncertainty uncertainty;
  /// Errors of the trusted points (mm, frame of the station) as a residual field predicts them that did not
  /// see their pose; empty without a field.
  std::vector<Eigen::Vector3d> unseen_mm;
  Calibration result;
};

/// Whether a stage weighs the points by its own model, or keeps the weights that they have.
enum class Weighing { Anew, Kept };

/// @name The stages, in their order
/// Each changes `id.fit` to its cell and notes in `id.result` what it found.
/// @{
/// Coarse: base and reflectors, the arm held at the nominal one.
/// Errors: NotSeparable.
std::optional<CalibrationError> fit_base_and_reflectors(Identification& id);
/// Fine: all that the data and, where it is wanted, the prior tell of the links. Errors: TooFewPoses.
std::optional<CalibrationError> fit_geometry(Identification& id, Weighing weighing = Weighing::Anew);
/// Where the options want them, the deviations of the joints that pay under cross-validation, together with
/// the geometry. What is an outlier to the geometry alone may be a good point to the richer model, or hide
/// from the poorer one: until both trust the same points, both are fitted again from those that the richer
/// one trusts. Errors: those of fit_geometry().
std::optional<CalibrationError> fit_deviations(Identification& id);
/// A field over what is left, and what it leaves in its turn. Errors: TooFewPoses.
std::optional<CalibrationError> fit_field(Identification& id);
/// @}

/// Solves `id.problem` from a cell, under any loss but the squared one by the robust chain: weights from a
/// redescending fit, then the plain fit under these weights.
FitResult fit_under_loss(Identification& id, const CalibratedCell& start);

/// The present problem with the trusted points alone.
struct TrustedProblem {
  std::vector<Measurement> points;
  LeastSquaresProblem problem;  ///< of these points
};
TrustedProblem trusted_problem(const Identification& id);

/// What a fit knows elsewhere, judged at poses that are spread over the joint limits.
TransferUncertainty transfer_of(const CalibratedCell& cell, const Eigen::MatrixXd& covariance);

/// How well the present fit is known.
/// @return what the points say of all parameters there, in as many rows as there are parameters, or points'
///         coordinates where these are fewer
Eigen::MatrixXd assess(Identification& id);

}  // namespace truepose
