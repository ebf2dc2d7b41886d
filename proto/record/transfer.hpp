#pragma once

#include <string>
#include <vector>

#include "core/calibrate/calibration.hpp"

namespace truepose::record {

/// How a joint sweeps its limits: `count` positions from one to the other, deg or mm.
struct Sweep {
  int joint = 0;  ///< from 1
  double from = 0, to = 0;
  int count = 0;
};

/// Standard deviation of a predicted position (mm) while two joints sweep and the others are held.
struct UncertaintyMap {
  Sweep x, y;
  std::vector<double> held;                   ///< of every joint, of which those two do not count; deg or mm
  std::vector<std::vector<double>> sigma_mm;  ///< [y][x]
};

/// How well unmeasured poses are known: one standard deviation of the first reflector's position.
struct Transfer {
  double rms_mm = 0, max_mm = 0;
  std::vector<double> worst_joints;  ///< deg or mm
  std::string warning;               ///< empty: nothing to warn of
  std::vector<UncertaintyMap> maps;  ///< joints 2 and 3 (the arm's vertical plane), and 1 and 2
};

/// Where the fit predicts worse than the nominal arm errs, in one sentence: which joints were measured over a
/// part of their range alone, where it is worst and what to do. Empty where it predicts better everywhere.
std::string transfer_warning(const Calibration& calibration, const MeasurementData& data);

/// Of a calibration whose covariance is known. The joints that a map holds are at the median of the poses
/// that identified.
Transfer transfer_of(const Calibration& calibration, const MeasurementData& data);

}  // namespace truepose::record
