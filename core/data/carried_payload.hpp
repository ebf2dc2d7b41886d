#pragma once

#include <span>

#include "core/data/measurement.hpp"

namespace truepose {

/// Whether the arm carried one thing at some points and another at others.
bool payload_varies(std::span<const Measurement> points);

/// The arm with what it carried when it was measured, where every point says so and all say the same; else as
/// it is.
RobotModel carrying_as_measured(RobotModel robot, std::span<const Measurement> points);

}  // namespace truepose
