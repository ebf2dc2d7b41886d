#pragma once

#include <expected>
#include <functional>

#include "core/identify/calibrate.hpp"

namespace truepose {

/// Whether any of the points tells how warm the arm was, in the way that is asked for.
bool tells_warmth(const MeasurementData& data, ThermalUse use);

/// The points with temperatures where these are to be reckoned by time: from 0, cold, at the first point of
/// each station to 1, warm through.
MeasurementData with_warmth_by_time(MeasurementData data, double time_constant_s);

/// Identifies how the arm answers to warmth, together with all that `identify` does, where that pays.
///
/// Points are brought to the reference temperatures by the response and identified from as if the arm had
/// stood there; the response is fitted to what that leaves, beside all parameters, and so on in turn: the two
/// meet within noise after two rounds, as both are nearly linear. The covariance is that of both together.
/// Whether it pays is asked of each point as the others predict it.
///
/// @param made  identified from `data` as it is
/// @param identify  from points at the reference
/// Errors: those of `identify`.
std::expected<Calibration, CalibrationError> with_thermal_response(
    Calibration made, const MeasurementData& data, const CalibrateOptions& options,
    const std::function<std::expected<Calibration, CalibrationError>(const MeasurementData&)>& identify);

}  // namespace truepose
