#pragma once

#include <expected>
#include <optional>
#include <string>

#include "core/calibrate/calibrate_options.hpp"
#include "core/calibrate/calibration.hpp"
#include "core/diagnosis/model_sanity.hpp"

namespace truepose {

enum class CalibrationFault {
  TooFewPoses,
  NotFinite,
  NotSeparable,  ///< base and reflector offset cannot be separated
  WrongModel,    ///< the nominal arm cannot be right
  WrongTurns,    ///< the orientations of targets do not follow the arm
  NoNoise,       ///< orientations without a noise of the positions that they are weighed against
};

struct CalibrationError {
  CalibrationFault fault;
  std::string detail;                  ///< one sentence for the operator
  std::optional<ProbableCause> cause;  ///< of WrongModel
};

/// Fits base and reflectors alone, the arm held at `arm`: the coarse stage. Few poses suffice, so a campaign
/// aims with it.
///
/// @param points  at least five poses of varying orientation, used whatever their set
std::expected<CalibratedCell, CalibrationError> coarse_fit(const RobotModel& arm,
                                                           const MeasurementData& data);

/// The data as the calibration has fitted them: at its reference temperatures.
MeasurementData as_fitted(const Calibration& calibration, const MeasurementData& data);

/// Identifies base, reflectors and link errors from the points marked Identify, and judges them on those
/// marked Validate.
///
/// @param nominal  the data sheet's arm
/// @param data     points to identify: more equations than identifiable parameters (9 poses of one reflector
/// give 27)
/// Source: method's paper, coarse stage (eqs 12 to 19) and fine stage (eqs 20 to 26).
std::expected<Calibration, CalibrationError> calibrate(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options = {});

}  // namespace truepose
