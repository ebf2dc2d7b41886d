#pragma once

#include <optional>
#include <vector>

#include "core/identify/calibrate.hpp"

namespace truepose {

/// What a point, measured as those that identified were, scatters by about the model's predictions with exact
/// parameters: the noise that the identification weighed by (all alike where none), scaled to the residuals
/// that it left. What the model does not describe is in it, as in the residuals.
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
