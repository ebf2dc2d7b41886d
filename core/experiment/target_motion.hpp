#pragma once

#include <optional>

#include "core/calibration/calibrated_cell.hpp"
#include "core/simulation/true_arm.hpp"

namespace truepose {

/// Joints at which the cell predicts its first reflector at a point, by the smallest joint change.
///
/// @param p_WS_mm  target of the reflector
/// @param q_seed   near it
/// @return nothing where the arm cannot reach it
std::optional<JointVector> joints_for_reflector(const CalibratedCell& cell, const Eigen::Vector3d& p_WS_mm,
                                                const JointVector& q_seed,
                                                const ApproachDirections& directions);

struct TrackerReadings {
  double noise_mm = 0;  ///< standard deviation of a coordinate
  int rounds = 6;
};

/// Tracker in the loop (TrackerLoop) at one target, without a tolerance.
///
/// @param arm   stands at `q` (its joints) for the target
/// @return where the arm truly stands at the end, its repeatability included
Eigen::Vector3d approach_with_tracker(TrueArm& arm, const CalibratedCell& cell,
                                      const Eigen::Vector3d& p_WS_mm, const JointVector& q,
                                      const TrackerReadings& readings, Random& random);

}  // namespace truepose
