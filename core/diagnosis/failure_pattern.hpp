#pragma once

#include <span>
#include <string>

#include "core/data/measurement.hpp"

namespace truepose {

/// Where points are missed that nothing explains: the third of a joint's range, of the rows or of the
/// workspace that stands out most, in words: "joint 3 from 41 to 90 deg: 310 mm, elsewhere 18 mm".
///
/// @param miss_mm  of each point
/// @return empty where they are missed alike everywhere
std::string failure_pattern(const RobotModel& arm, std::span<const Measurement> points,
                            std::span<const double> miss_mm);

}  // namespace truepose
