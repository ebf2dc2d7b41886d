#pragma once

#include <Eigen/Core>
#include <span>

namespace truepose {

/// How far orientations of a flange differ, in the direction of the flange in which they do least.
struct OrientationSpread {
  Eigen::Vector3d stiff_F{0, 0, 1};  ///< that direction, flange frame, of length 1
  double tilt_rad = 0;               ///< by which it is tilted from its mean, root mean square
};

/// @param turns  R_BF, at least one
OrientationSpread orientation_spread(std::span<const Eigen::Matrix3d> turns);

}  // namespace truepose
