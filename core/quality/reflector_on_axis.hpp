#pragma once

#include <optional>
#include <span>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"
#include "core/quality/calibration_verdict.hpp"

namespace truepose {

/// Advice where all reflectors stand so near the axis of the last joint that turning it moves none of them by
/// more than noise: nothing that the link behind it does can be seen.
///
/// @param cell      as identified
/// @param points    to identify
/// @param sigma_mm  standard deviation of one coordinate of a point about the model
std::optional<Finding> reflectors_on_last_axis(const CalibratedCell& cell,
                                               std::span<const Measurement> points, double sigma_mm);

}  // namespace truepose
