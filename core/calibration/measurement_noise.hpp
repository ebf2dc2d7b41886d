#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "core/calibration/measurement.hpp"

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

/// What blurs one measured point: the tracker's reading, and the arm, which does not come back to the same
/// place.
struct MeasurementNoise {
  TrackerNoiseModel tracker;
  double repeatability_mm = 0;  ///< standard deviation per axis of the arm's position
};

/// Covariance (mm^2, tracker frame, the tracker at its origin) of one reading at p_WS.
Eigen::Matrix3d reading_covariance(const Eigen::Vector3d& p_WS_mm, const MeasurementNoise& noise);

/// What makes the residuals of points alike: W with W'W = s^2 times the inverse covariance of a point, where
/// s is the finest standard deviation of all, so that a whitened residual stays in mm.
struct Whitening {
  std::vector<Eigen::Matrix3d> W;  ///< one per point; empty = all points alike, their noise unknown
  double finest_mm = 0;            ///< s, 0 where the noise is unknown
};

/// By each point's stated sigma where every point has one, else by the noise model where there is one, else
/// all alike.
Whitening whitening_of(std::span<const Measurement> points, const std::optional<MeasurementNoise>& noise);

}  // namespace truepose
