#pragma once

#include <span>
#include <vector>

#include "core/calibration/measurement.hpp"

namespace truepose {

/// Indices of the points of each pose: points with the same joints are one pose. Poses in the order of first
/// appearance.
std::vector<std::vector<std::size_t>> pose_groups(std::span<const Measurement> points);

}  // namespace truepose
