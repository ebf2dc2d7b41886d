#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "core/identify/measurement.hpp"

namespace truepose {

/// So many times the stated noise contradicts it: what repeated readings may scatter by, or the tracker say
/// of one point.
inline constexpr double kMostScatter = 5;

/// Whether one and the same pose, measured again and again, did not stay where it was: off by more than the
/// stated noise explains, and moved by more than matters to a model of this accuracy.
///
/// @param accuracy_mm  mean error of the model
/// @return a clause; nothing where it stayed, or was measured less than twice
std::optional<std::string> moved_reference(std::span<const Eigen::Vector3d> readings_mm,
                                           const MeasurementNoise& stated, double accuracy_mm);

}  // namespace truepose
