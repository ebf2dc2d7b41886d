#pragma once

#include <optional>
#include <vector>

#include "core/calibrate/calibration.hpp"

namespace truepose {

/// What a point, measured as those that identified were, scatters by about the model's predictions with exact
/// parameters: the noise that the identification weighed by (all alike where none). What the residuals show
/// beyond it is what the model does not describe, and counts to the arm's repeatability, so that it is in
/// what the arm is promised to do too; where they show less, the noise is scaled to them.
///
/// @param stated  the noise model of the identification's options
MeasurementNoise noise_about_model(const Calibration& calibration, const MeasurementData& data,
                                   const std::optional<MeasurementNoise>& stated);

/// point_distances2() of the validation points; empty where nothing was validated.
///
/// @param about  by noise_about_model()
std::vector<double> validation_distances2(const Calibration& calibration, const MeasurementData& data,
                                          const MeasurementNoise& about);

/// The noise about a model that says no more than its mean error on validation poses.
MeasurementNoise noise_of_mean_error(double mean_mm);

}  // namespace truepose
