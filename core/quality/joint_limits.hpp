#pragma once

#include <optional>
#include <span>

#include "core/arm/robot_model.hpp"
#include "core/data/measurement.hpp"
#include "core/quality/calibration_verdict.hpp"

namespace truepose {

/// Advice if joints were measured beyond the limits of the nominal arm, by more than an encoder reads at a
/// hard stop. Statements over the joint limits then hold for another range than the arm's.
std::optional<Finding> measured_beyond_limits(const RobotModel& nominal, std::span<const Measurement> points);

}  // namespace truepose
