#pragma once

#include <Eigen/Core>
#include <expected>
#include <span>
#include <string>
#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// A calibrated cell and how far its predictions can be trusted.
struct DriftReference {
  CalibratedCell cell;
  /// Of the parameters, as Calibration::covariance; empty: taken as exact, all scatter is in the noise.
  Eigen::MatrixXd covariance;
  MeasurementNoise noise;         ///< of a measured point about what exact parameters would predict
  double validation_mean_mm = 0;  ///< mean error on validation poses; 0 = nothing was validated
  /// point_distances2() of the validation points: how the model's errors really scatter. Empty: as normal
  /// errors would, all about the model is taken as it says of itself.
  std::vector<double> validation_distances2;
};

/// The stacked residuals of some points and what they depend on, made alike: multiplied by the inverse of L,
/// where L L' = S = J C J' + N, the covariance C of the parameters and the noise N of each point.
struct DriftResiduals {
  Eigen::VectorXd r;        ///< measured minus predicted, whitened
  Eigen::MatrixXd J;        ///< derivative of the predictions to the parameters, whitened (ParameterLayout)
  Eigen::MatrixXd inverse;  ///< of L
  Eigen::MatrixXd S;        ///< mm^2
};

/// @param cell  that of the reference, or that with something moved
/// Errors: no point, a number that is not finite, an S that is not positive definite.
std::expected<DriftResiduals, std::string> drift_residuals(const DriftReference& reference,
                                                           const CalibratedCell& cell,
                                                           std::span<const Measurement> points);

/// Squared length of r of each point, regarded alone.
///
/// Errors: as drift_residuals().
std::expected<std::vector<double>, std::string> point_distances2(const DriftReference& reference,
                                                                 std::span<const Measurement> points);

}  // namespace truepose
