#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/change/movement.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose {

/// A station of which nearly all points are such that nothing explains, and off in the same way, from a
/// moment on or up to it, and few of the others: then it is they that moved.
///
/// @param points  in the order in which they were measured
/// @param is_far  of each of them, whether nothing explains it
std::optional<Movement> far_stretch(const CalibratedCell& cell, std::span<const Measurement> points,
                                    const std::vector<bool>& is_far);

}  // namespace truepose
