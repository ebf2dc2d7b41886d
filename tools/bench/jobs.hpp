#pragma once

#include <vector>

#include "core/data/calibrated_cell.hpp"
#include "core/data/measurement.hpp"

namespace truepose::bench {

/// The KR 210 R2700-2 and, in `calibrated`, the errors that the method's paper injects (tables 1 and 2).
RobotModel kr210(bool calibrated);

/// Joint positions of that arm, anywhere within its limits.
std::vector<JointVector> joint_positions(int count);

/// Noise-free points of a cell whose arm, base and reflector are off from `start`, so that every solver can
/// be run to the same end.
struct Identification {
  CalibratedCell start;  ///< nominal arm; base and reflector as a coarse stage leaves them
  std::vector<Measurement> points;
  std::vector<int> free;  ///< the 27 parameters that points of one reflector can tell apart
};
Identification identification(int points);

/// RMS position error (mm) at which an identification counts as done.
inline constexpr double kDone_mm = 1e-9;

/// RMS of the predicted minus the measured positions.
double rms_mm(const CalibratedCell& cell, const std::vector<Measurement>& points);

/// A pose of the calibrated arm, and joints some 5 deg off from those that reach it.
struct InverseTarget {
  Eigen::Isometry3d X_BF;
  JointVector seed;
};
const std::vector<InverseTarget>& inverse_targets();

}  // namespace truepose::bench
