#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/calibration/calibrate.hpp"

namespace truepose {

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
