#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/calibrate/calibration.hpp"
#include "core/data/measurement.hpp"
#include "core/named.hpp"
#include "core/quality/finding_kinds.hpp"

namespace truepose {

enum class VerdictColor { Green, Amber, Red };
inline constexpr std::array kVerdictColorNames{Named{"green", VerdictColor::Green},
                                               Named{"amber", VerdictColor::Amber},
                                               Named{"red", VerdictColor::Red}};

struct CalibrationVerdict {
  std::vector<Finding> findings;  ///< the gravest first

  /// Green: no more than notes. Red: an error. Amber: all between.
  VerdictColor color() const;
  /// Whether a test failed: then a command ends with 1, and no daemon uses the model before an operator
  /// confirms it.
  bool failed() const;
};

/// What a calibration is judged by.
struct CalibrationEvidence {
  const Calibration& calibration;
  const MeasurementData& data;                         ///< in the order in which it was measured
  std::optional<MeasurementNoise> stated = {};         ///< where the points do not state their own
  std::span<const Eigen::Vector3d> reference_mm = {};  ///< one and the same pose, measured again and again
  std::optional<double> tolerance_mm = {};             ///< that no error may exceed
  std::optional<ErrorStatistics> remeasured = {};  ///< of validation poses reached with compensated joints
  /// Whether the model's use is known to be where it was measured: else it is that of the whole arm.
  bool task_stated = false;
  std::span<const Finding> further_findings = {};  ///< what was found while it was measured
};

/// Whether a calibration may be trusted: the one answer to that, on the command line, in the daemon and in
/// reports. It asks whether
/// - the identification converged and is nearer to the validation points than the nominal arm (a positioner,
///   whose place is what was asked, may come as near without),
/// - what the model leaves is no more than what real arms have beyond a model,
/// - nothing moved while it was measured (movement(); a warning where a joint's own errors explain the points
///   as well), and the reference pose stayed where it was, as far as the stated noise and the accuracy that
///   the validation found make that out,
/// - the validation points agree with what the model predicts, by drift_check()'s two questions, for the
///   noise that the identification left or the stated one, whichever is more,
/// - enough poses validate that the identification has not seen, and they do not come nearer than the noise,
/// - few points are beyond six sigma, and none of those that validate that changes their errors by a tenth,
/// - the largest error, measured again where it was, keeps to the tolerance,
/// - the poses take up enough of the joints' ranges, which are given to enough decimals, and
/// - unmeasured poses are known better than by the data sheet.
///
/// A sound campaign is doubted by chance less often than one in two hundred times.
CalibrationVerdict calibration_verdict(const CalibrationEvidence& evidence);

}  // namespace truepose
