#pragma once

#include <functional>

#include "core/calibrate/identification.hpp"

namespace truepose {

/// So many poses tell where a station is by themselves, and so many by reflectors that another has seen.
inline constexpr int kPosesToPlace = 5, kPosesToPlaceByReflectors = 3;

/// Where the coarse stage of several stations starts, the one with the most points first: base and reflectors
/// from the points of one station alone, or its base from the reflectors that those before have found.
///
/// @param alone  start of an identification from one station
/// Errors: TooFewPoses naming the station.
std::expected<CalibratedCell, CalibrationError> station_start(
    const Identification& id, const std::function<CalibratedCell(const Identification&)>& alone);

}  // namespace truepose
