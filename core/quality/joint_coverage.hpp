#pragma once

#include <optional>
#include <span>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/quality/calibration_verdict.hpp"

namespace truepose {

/// A doubt where the poses take up less than a quarter of the range of most joints: the model was seen there
/// alone, and errors that it does not describe are others elsewhere.
///
/// @param robot   whose limits are the ranges
/// @param points  to identify; a tenth of them may stand apart
std::optional<Finding> narrow_poses(const RobotModel& robot, std::span<const Measurement> points);

/// A doubt where all joints are given to whole degrees or to one decimal, and advice where they are given to
/// two, if what the cell leaves at the points is what that rounding makes of a joint's true position.
std::optional<Finding> rounded_joints(const CalibratedCell& cell, std::span<const Measurement> points);

}  // namespace truepose
