#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// Chooses poses in which the flange is turned as differently as can be: always the one whose orientation is
/// farthest from the nearest of those before it.
///
/// @param count  at least one, and no more than there are candidates
/// @return indices of the candidates
std::vector<std::size_t> most_different_orientations(const RobotModel& robot,
                                                     std::span<const JointVector> candidates,
                                                     std::size_t count);

}  // namespace truepose
