#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "core/data/measurement.hpp"

namespace truepose {

/// One point as a tracker reads it in its first face, and as the mean of both faces. mm, tracker frame.
struct FacePair {
  Eigen::Vector3d face1_mm{0, 0, 0};
  Eigen::Vector3d mean_mm{0, 0, 0};
};

/// By what a tracker (at the origin, its axis along z) errs in directions in its first face, and by as much
/// the other way in its second: the constants of a theodolite. rad.
struct AimingConstants {
  Eigen::Vector3d value{0, 0, 0};  ///< collimation, tilt of the transit axis, index of the vertical circle
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double probability = 1;  ///< that a tracker without such errors shows as much
  double fit = 1;          ///< that what they leave is the stated noise
  double largest_mm = 0;   ///< greatest error of one face among the points

  bool significant() const;
  /// A point that was read in face 1, without them.
  Eigen::Vector3d corrected(const Eigen::Vector3d& face1_mm) const;
};

/// The constants that explain best, by the noise, how the faces differ. Each is taken to be some 0.1 mrad
/// before it is measured, so that one that no point shows stays near 0.
///
/// Nothing where fewer than three points were seen in both faces.
std::optional<AimingConstants> aiming_constants(std::span<const FacePair> pairs,
                                                const TrackerNoiseModel& noise);

/// "in one face the tracker errs by up to 0.061 mm (collimation 20 (sigma 1), tilt .., index .. urad)".
std::string described(const AimingConstants& constants);

}  // namespace truepose
