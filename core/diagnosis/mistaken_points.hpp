#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// What is wrong with all points alike, where a calibrated cell says so: units, columns, joints that stand
/// beside another row's point ("the points are in m, not mm").
///
/// Said where the points are more than a centimetre off in the middle and a fiftieth of that remains once it
/// is mended.
///
/// @param points  in the order of the file
std::optional<std::string> mistaken_points(const CalibratedCell& cell, std::span<const Measurement> points);

}  // namespace truepose
