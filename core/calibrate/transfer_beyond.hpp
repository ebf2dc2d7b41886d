#pragma once

#include "core/calibrate/identification.hpp"

namespace truepose {

/// Standard deviation of a coordinate of what the model leaves beyond the noise, and beyond what that
/// scatters by by chance (mm). Where no noise is stated it is taken as that of usual trackers and arms.
double misfit_mm(const Identification& id);

/// How well poses are predicted anywhere: by what the parameters and the field leave open, what the model
/// does not describe, how much worse that is where nothing was measured, and how much worse the validation
/// found it all.
///
/// @param result  with its misfit
/// @param fitted  as fitted
TransferUncertainty transfer_beyond(const Calibration& result, const Identification& id,
                                    const MeasurementData& fitted);

}  // namespace truepose
