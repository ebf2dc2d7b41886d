#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// What is wrong with all points alike, where a calibrated cell says so: units, columns, joints in the row of
/// another point ("the points are in m, not mm").
///
/// Reported if the median error of the points is more than a centimetre and the fix reduces it to a fiftieth.
///
/// @param points  in the order of the file
std::optional<std::string> mistaken_points(const CalibratedCell& cell, std::span<const Measurement> points);

}  // namespace truepose
