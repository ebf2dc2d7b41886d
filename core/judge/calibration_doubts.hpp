#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/identify/calibrate.hpp"
#include "core/identify/calibrated_cell.hpp"
#include "core/identify/measurement.hpp"

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

/// So many times the stated noise contradicts it: what repeated readings may scatter by, or the tracker say
/// of one point.
inline constexpr double kMostScatter = 5;

/// What a calibration is judged by before it corrects an arm without anybody having looked at it.
struct CalibrationEvidence {
  const Calibration& calibration;
  const MeasurementData& data;                    ///< in the order in which it was measured
  std::span<const Eigen::Vector3d> reference_mm;  ///< one and the same pose, measured again and again
  MeasurementNoise stated;                        ///< by the configuration
};

/// What contradicts a calibration, one sentence each; empty: nothing does. It asks whether
/// - the reference pose stayed where it was, as far as the stated noise and the accuracy that the validation
///   found make that out,
/// - the validation points agree with what the model predicts, by drift_check()'s two questions, for the
/// noise
///   that the identification left or the stated one, whichever is more,
/// - nothing moved from one moment on (step_in_time()),
/// - what the model leaves is no more than what real arms have beyond a model.
///
/// A sound campaign is doubted by chance less often than one in a hundred times.
std::vector<std::string> calibration_doubts(const CalibrationEvidence& evidence);

}  // namespace truepose
