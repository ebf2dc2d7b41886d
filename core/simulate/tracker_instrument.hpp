#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <chrono>
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

/// What a tracker that was switched on a moment ago reads too much; it goes as exp(-t / minutes).
struct TrackerWarming {
  double range_mm = 0;        ///< of every distance
  double horizontal_rad = 0;  ///< of the horizontal angle
  double vertical_rad = 0;    ///< of the angle from the zenith
  double minutes = 30;
  bool operator==(const TrackerWarming&) const = default;

  /// What it reads of a point so long after it was switched on.
  Eigen::Vector3d seen(const Eigen::Vector3d& p_W_mm, std::chrono::duration<double> age) const;
};

/// A tripod that gives way: all that its tracker sees moves, in its frame, little by little.
struct TripodDrift {
  Eigen::Vector3d mm_per_hour{0, 0, 0};
  Eigen::Vector3d rad_per_hour{0, 0, 0};  ///< about the axes of the tracker
  bool operator==(const TripodDrift&) const = default;

  /// By which all that it sees has moved so long after it was set up.
  Eigen::Isometry3d motion(std::chrono::duration<double> age) const;
  /// Where a point is seen that stood at p_W_mm when it was set up.
  Eigen::Vector3d moved(const Eigen::Vector3d& p_W_mm, std::chrono::duration<double> age) const;
};

/// How a tracker and what is before it really are.
struct TrackerInstrument {
  AimingErrors aiming;
  TrackerWarming warming;
  TripodDrift stand;
  bool weather_station = true;
  std::optional<Air> air;                 ///< that it measures through; none: what it corrects by
  std::vector<Eigen::Vector3d> nests_mm;  ///< fixed reflectors, in addition to those on the arm
};

/// Refractive index for a modulation of light of 795 nm. Its own formula, so that it can judge those of
/// core/math.
/// Source: Birch, Downs, Correction to the updated Edlen equation, Metrologia 31 (1994).
double edlen_group_index(const Air& air);

}  // namespace truepose
