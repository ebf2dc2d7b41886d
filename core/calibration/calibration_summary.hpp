#pragma once

#include "core/calibration/identification.hpp"

namespace truepose {

/// Completes the result of an identification that has been through its stages: the cell, its parameters with
/// their uncertainty, the points that were rejected, and the errors of all points through the stages.
Calibration summary(Identification id);

}  // namespace truepose
