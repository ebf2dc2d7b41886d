#pragma once

#include <optional>

#include "core/calibration/calibrated_cell.hpp"
#include "core/simulation/true_arm.hpp"

namespace truepose {

/// Joints at which the cell predicts its first reflector at a point: Newton with the smallest joint change.
///
/// @param p_WS_mm  target of the reflector
/// @param q_seed   near it
/// @return nothing where it does not come within a nanometre in 20 steps
std::optional<JointVector> joints_for_reflector(const CalibratedCell& cell, const Eigen::Vector3d& p_WS_mm,
                                                const JointVector& q_seed,
                                                const ApproachDirections& directions);

struct TrackerLoopOptions {
  double tracker_noise_mm = 0;
  int rounds = 6;
};

/// Tracker in the loop: measures the arm, corrects it by a share of what is missing, and measures again.
///
/// The share is 1, 1/2, 1/3 and so on: the correction is then the mean of all readings, and the noise of a
/// single one is not followed to the end.
/// @param arm   stands at `q` (its joints) for the target
/// @return where the arm truly stands at the end, its repeatability included
Eigen::Vector3d approach_with_tracker(TrueArm& arm, const CalibratedCell& cell,
                                      const Eigen::Vector3d& p_WS_mm, JointVector q,
                                      const TrackerLoopOptions& options, Random& random);

}  // namespace truepose
