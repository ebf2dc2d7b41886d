#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "core/calibrate/calibrate_options.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/quality/calibration_verdict.hpp"
#include "core/simulate/true_arm.hpp"

namespace truepose {

/// A campaign to be: what a tracker on a stand a few metres away sees of an arm that errs as real ones do.
struct DrawnCell {
  Random random;
  RobotModel nominal;
  TrueArmSetup truth;
  int identify = 0, validate = 0;
  double noise_mm = 0.02;    ///< of a coordinate that the tracker reads, as it is stated
  double true_noise_mm = 0;  ///< 0: as stated
  double within = 1;         ///< of the joints' ranges
  CalibrateOptions options;
  /// What happens before the point of this number, of so many.
  std::function<void(TrueArm& arm, TrueArmSetup& truth, int point, int of)> before;
  std::function<void(MeasurementData& data, Random& random)> spoil;
  double rounded_deg = 0;            ///< joints are given so
  bool warms = false, sees = false;  ///< those poses alone whose reflector the tracker sees
  bool in_order = false;             ///< all points are of one file, in the order in which they were measured
  bool states_noise = true, reads_time = false;
};

inline double turn(double deg) { return deg * kRadPerDeg; }

/// Sound: arm, base, reflectors, noise, poses, layers and files are drawn.
DrawnCell sound_cell(std::uint64_t seed);

struct JudgedCampaign {
  MeasurementData data;
  Calibration calibration;
  CalibrationVerdict verdict;
  double true_rms_mm = 0;  ///< of the model over the joint limits
  bool refused = false;
  std::string refusal;
};

/// Measures, calibrates and judges it.
JudgedCampaign judged(DrawnCell cell, std::uint64_t seed);

}  // namespace truepose
