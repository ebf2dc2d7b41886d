#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/math/refraction.hpp"

namespace truepose {

/// What is constant in a tracker's directions, so that no average lessens it. rad, in face 1; turned over, in
/// face 2, the instrument errs by as much the other way.
struct AimingErrors {
  double collimation = 0;  ///< of the beam against its axis: 1 / sin of the vertical angle
  double tilt = 0;         ///< of the transit axis: its cotangent
  double index = 0;        ///< of the vertical circle
  bool operator==(const AimingErrors&) const = default;

  /// What the tracker (at the origin, its axis along z) reads of a point in face 1 or 2.
  Eigen::Vector3d seen(const Eigen::Vector3d& p_W_mm, int face) const;
};

/// How a tracker and what is before it really are.
struct TrackerInstrument {
  AimingErrors aiming;
  bool weather_station = true;
  std::optional<Air> air;                 ///< that it measures through; none: what it corrects by
  std::vector<Eigen::Vector3d> nests_mm;  ///< reflectors that stand beside the arm's
};

/// Refractive index for a modulation of light of 795 nm. Its own formula, so that it can judge those of
/// core/math.
/// Source: Birch, Downs, Correction to the updated Edlen equation, Metrologia 31 (1994).
double edlen_group_index(const Air& air);

}  // namespace truepose
