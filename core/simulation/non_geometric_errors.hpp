#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/kinematics/robot_model.hpp"

namespace truepose {

/// Direction in which each joint last moved: 1 to greater q, -1 to smaller q, 0 unknown. Empty = all unknown.
using ApproachDirections = std::vector<std::int8_t>;

/// One sine over the joint angle: amplitude * sin(order * q + phase).
struct GearHarmonic {
  double amplitude_rad = 0;
  double phase_rad = 0;
};

/// How one joint's drive misses the angle that its encoder, before the gear, reads.
struct DriveError {
  double compliance_rad_per_Nm = 0;
  std::array<GearHarmonic, 2> harmonics;  ///< of the order 1 and 2: eccentricity and ovality of the gear
  double backlash_rad = 0;                ///< full width of the play
};

/// Errors of an arm that no link length or angle describes. Masses and drives, one per joint; empty = none.
struct NonGeometricErrors {
  std::vector<LinkMass> masses;
  std::vector<DriveError> drives;
  Eigen::Vector3d gravity_B_mps2{0, 0, -9.80665};
};

/// How much further than the encoders say the joints stand (rad, in the sign convention of q).
///
/// The joints are springs in series with the gears: the deflection is that of the equilibrium, so the torque
/// is taken at the deflected arm. Play leaves a joint half its width behind where it last moved to.
/// A prismatic joint is rigid.
/// @param arm    with its true geometry
/// @param directions  of each joint, or empty
JointVector joint_displacement(const RobotModel& arm, const NonGeometricErrors& errors, const JointVector& q,
                               const ApproachDirections& directions);

/// Torque (N m, along +q) that gravity exerts on each revolute joint; 0 for a prismatic one.
JointVector gravity_torque_Nm(const RobotModel& arm, const NonGeometricErrors& errors, const JointVector& q);

struct HeavyArmOptions {
  double payload_kg = 100;
  bool compliance = true;
  bool harmonics = true;
  double backlash_rad = 0;
  std::uint64_t seed = 0;  ///< of the harmonics' phases and amplitudes
};

/// Plausible errors of a KR 210 R2700-2 (frames as in its robot file): masses that add up to the moving part
/// of its 1.1 t, no counterbalance, and gears of 0.05 to 0.15 mrad in the first order and a third of that in
/// the second. The joints, of 8 to 20 MN m/rad in the main axes and 1 to 2 in the wrist, are stiff enough
/// that a purely geometric model is left with 0.4 to 0.5 mm, as real arms of this size are.
NonGeometricErrors heavy_arm_errors(const HeavyArmOptions& options);

}  // namespace truepose
