#pragma once

#include <Eigen/Core>

#include "core/random.hpp"

namespace truepose {

/// Standard deviations of a tracker's reading along the beam and in each direction across it: a constant and
/// a part that grows with the distance.
///
/// Spherical, since a tracker knows distances better than directions: its cloud of errors is flat along the
/// beam.
struct TrackerNoiseModel {
  double range_mm = 0;
  double range_mm_per_m = 0;
  double transverse_mm = 0;
  double transverse_mm_per_m = 0;
};

/// One reading of a point. mm, tracker frame (the tracker stands at its origin).
Eigen::Vector3d noisy_reading(const Eigen::Vector3d& p_true_mm, const TrackerNoiseModel& model,
                              Random& random);

}  // namespace truepose
