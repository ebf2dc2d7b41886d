#pragma once

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/fit/thermal_response.hpp"

namespace truepose {

/// Of data with the warmth of the points as temperatures, as with_warmth_by() leaves it.
bool warmth_is_open(const Measurement& point);

/// Points that validate and of which nothing says how warm the arm was, moved to where an arm at the
/// reference would have shown them.
///
/// The warmth of each pose is taken from its own readings: it scatters as that of the points to identify
/// does, and is never beyond theirs. What is left of a reading is enlarged by the freedom that this takes, so
/// that the errors of such points are on average those of points whose warmth is known.
///
/// @param data      with the warmth of all other points as temperatures, as with_warmth_by() leaves it
/// @param cell      at the reference
/// @param sigma_mm  standard deviation of one coordinate of a reading about the model
MeasurementData with_open_warmth(MeasurementData data, const CalibratedCell& cell,
                                 const ThermalResponse& response, double sigma_mm);

}  // namespace truepose
