#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "core/calibration/calibrated_cell.hpp"
#include "core/calibration/measurement.hpp"
#include "core/calibration/measurement_noise.hpp"

namespace truepose {

/// The tracker or the base moved while it was measured.
struct StepInTime {
  std::size_t first = 0;  ///< point after the step, from 0
  double moved_mm = 0;    ///< what it did to the points after it, on average
};

/// Looks for a moment from which on all points are moved as by another base.
///
/// The identified parameters have taken in a part of such a step, so they are left free: what their columns
/// cannot explain of the residuals is compared with and without six more columns, those of the base for the
/// points after the moment. A step is one that leaves less than half of the standard deviation (each by its
/// degrees of freedom), where what is left without it is more than the stated noise. What a model does not
/// describe of an arm does not come and go at one moment, so that it does not look like a step.
///
/// @param points  in the order in which they were measured
std::optional<StepInTime> step_in_time(const CalibratedCell& cell, std::span<const Measurement> points,
                                       const MeasurementNoise& stated);

}  // namespace truepose
