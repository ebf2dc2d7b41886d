#pragma once

#include <Eigen/Core>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace truepose {

/// A pose of the measured point, commanded or attained, in the robot's base frame (or one parallel to it).
struct TestPose {
  Eigen::Vector3d p_mm{0, 0, 0};
  std::optional<Eigen::Matrix3d> R;  ///< none: only the position is known
};

// The characteristics of ISO 9283:1998, clause 7. Its a, b, c are small turns about the x, y, z axes of the
// base (KUKA's A, B, C are about z, y, x), and its formulae subtract angles. Subtracted Euler angles jump at
// +-180 deg and mean nothing in KUKA's gimbal at B = 90 deg, so that turns are taken here as rotation
// vectors: from the commanded orientation for AP, from the mean one for RP. For small turns that is what the
// standard says. Orientation is left out where any of the poses has none.

/// Pose accuracy AP (7.2.1): the mean attained pose less the commanded one.
struct PoseAccuracy {
  double p_mm = 0;                         ///< AP_p, the length of (AP_x, AP_y, AP_z)
  Eigen::Vector3d xyz_mm{0, 0, 0};         ///< AP_x, AP_y, AP_z
  std::optional<Eigen::Vector3d> abc_rad;  ///< AP_a, AP_b, AP_c
};

/// Pose repeatability RP (7.2.2): how closely the attained poses agree.
struct PoseRepeatability {
  double l_mm = 0;                         ///< RP_l = mean distance from the barycentre + 3 S_l
  double mean_mm = 0;                      ///< of these distances
  double std_mm = 0;                       ///< S_l, n - 1 in its denominator
  std::optional<Eigen::Vector3d> abc_rad;  ///< RP_a, RP_b, RP_c: +-3 S_a, S_b, S_c
};

/// Multi-directional pose accuracy variation vAP (7.2.3): the greatest difference between the mean poses
/// attained from different directions.
struct AccuracyVariation {
  double p_mm = 0;                         ///< vAP_p
  std::optional<Eigen::Vector3d> abc_rad;  ///< vAP_a, vAP_b, vAP_c
};

/// Drift of pose characteristics (7.6): the greatest change of AP and RP from the first series to any later
/// one.
struct PoseDrift {
  double ap_p_mm = 0;                         ///< dAP_p
  double rp_l_mm = 0;                         ///< dRP_l
  std::optional<Eigen::Vector3d> ap_abc_rad;  ///< dAP_a, dAP_b, dAP_c
  std::optional<Eigen::Vector3d> rp_abc_rad;  ///< dRP_a, dRP_b, dRP_c
  /// The greatest way of the barycentre from where it was in the first series. Not of the standard, whose
  /// dAP_p stays 0 while the pose wanders around the commanded one.
  double moved_mm = 0;
};

/// Mean position (the barycentre) and mean orientation (from which the rotation vectors sum to zero).
///
/// @param attained  at least one
TestPose mean_pose(std::span<const TestPose> attained);

/// @param attained  at least one, of the n cycles
PoseAccuracy pose_accuracy(const TestPose& commanded, std::span<const TestPose> attained);

/// Errors: fewer than two poses, which have no repeatability.
std::expected<PoseRepeatability, std::string> pose_repeatability(std::span<const TestPose> attained);

/// @param means  mean_pose() of each direction of approach, at least two
AccuracyVariation accuracy_variation(std::span<const TestPose> means);

/// AP and RP of one pose in one series of cycles.
struct SeriesCharacteristics {
  PoseAccuracy accuracy;
  PoseRepeatability repeatability;
};

/// @param series  in the order of time, at least two
PoseDrift pose_drift(std::span<const SeriesCharacteristics> series);

}  // namespace truepose
