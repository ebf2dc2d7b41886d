#pragma once

#include <vector>

#include "core/calibrate/identification.hpp"

namespace truepose {

/// Points that no noise explains, set by set.
struct RejectedPoints {
  std::vector<RejectedPoint> to_identify, to_validate;
};

/// Points that take no part in the fit: those that were screened out before it, or that its loss takes out.
std::vector<RejectedPoint> rejected(const Identification& id, const RejectedPoints& rejected_points);

/// Completes the result of an identification that has been through its stages: the cell, its parameters with
/// their uncertainty, the points that were rejected, and the errors of all points through the stages.
///
/// @param rejected_points  what the identification was made without
/// @param data      all that was measured
Calibration summary(const Identification& id, const RejectedPoints& rejected_points,
                    const MeasurementData& data);

}  // namespace truepose
