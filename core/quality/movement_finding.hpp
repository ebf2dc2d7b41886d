#pragma once

#include <cstddef>
#include <string>

#include "core/change/movement.hpp"
#include "core/data/measurement.hpp"
#include "core/quality/finding_kinds.hpp"

namespace truepose {

/// "row 12", of several stations "row 12 of 'door.csv'"; of a campaign "pose 12".
std::string place_of(const MeasurementData& data, std::size_t index);

/// What a verdict says of a movement.
///
/// @param mean_error_mm  of the calibration: a movement or warmth of as little does no harm
Finding finding_of(const Movement& moved, const CalibratedCell& cell, const MeasurementData& data,
                   double mean_error_mm);

}  // namespace truepose
