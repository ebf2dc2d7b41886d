#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/data/measurement.hpp"
#include "core/math/random.hpp"
#include "core/simulate/warm_up.hpp"

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

/// One reading of a point. mm, tracker frame (the tracker stands at its origin).
Eigen::Vector3d noisy_reading(const Eigen::Vector3d& p_true_mm, const TrackerNoiseModel& model,
                              Random& random);

/// One reading of the orientation of a 6-D target.
/// @param sigma_rad  of a rotation about each axis
MeasuredOrientation noisy_orientation(const Eigen::Matrix3d& R_true, double sigma_rad, Random& random);

/// A further reflector on the flange. mm, rad.
struct TrueReflector {
  Eigen::Vector3d p_FS_mm{0, 0, 0};
  Eigen::Vector3d facing_F{0, 0, 1};           ///< any length but zero
  double acceptance_rad = 0.5235987755982988;  ///< 30 deg
};

/// How an arm, its base and its reflectors really are. mm and rad.
struct TrueArmSetup {
  RobotModel robot;                  ///< with the errors that a calibration has to find
  NonGeometricErrors non_geometric;  ///< compliance, gears and play of the joints; by default none
  WarmUp warm_up;                    ///< by default none
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::Vector3d p_FS_mm{0, 0, 0};
  Eigen::Vector3d facing_F{0, 0, 1};           ///< direction of the reflector's opening, any length but zero
  double acceptance_rad = 0.5235987755982988;  ///< half angle of the cone in which the beam returns (30 deg)
  double repeatability_mm = 0;                 ///< standard deviation per axis, drawn at each stop
  std::vector<TrueReflector> further{};        ///< in addition to that one
  Eigen::Matrix3d R_FT = Eigen::Matrix3d::Identity();  ///< how the first is mounted where it is a 6-D target
};

/// The arm as it really is: given the joints that its controller reads, where the reflector truly stands.
class TrueArm {
 public:
  TrueArm(TrueArmSetup setup, std::uint64_t seed);

  /// The arm came to a stand: it stands a little elsewhere than the last time (ISO 9283 repeatability).
  void stop_anew();

  /// It is so long ago that the cold arm was switched on; before the first call it is cold.
  void warm_up(Seconds since_start);

  /// The arm moved and came to a stand: it remembers the direction in which each joint moved. A joint that
  /// did not move keeps its direction.
  void move(const JointVector& from, const JointVector& to);
  /// The same from where the last move ended; the first knows no direction.
  void move_to(const JointVector& q);

  /// Direction in which each joint last moved; empty before the first.
  const ApproachDirections& directions() const { return directions_; }

  /// Moves the first reflector to another place on the flange, opened as before.
  void put_reflector(const Eigen::Vector3d& p_FS_mm) {
    setup_.p_FS_mm = reflectors_.front().p_FS_mm = p_FS_mm;
  }

  /// Reflectors on the flange; they count from 0, the first.
  std::size_t reflectors() const { return reflectors_.size(); }
  /// True centre of a reflector in the tracker frame, with the deviation and the directions of the last stop.
  Eigen::Vector3d p_WS_mm(const JointVector& q, std::size_t reflector = 0) const;

  /// How the first reflector's axes are turned in the tracker frame, if it is a 6-D target.
  Eigen::Matrix3d R_WT(const JointVector& q) const;

  /// Whether the beam comes back: the tracker (origin of W) is inside the reflector's acceptance cone, and
  /// the reflector above the floor on which the base stands.
  bool visible(const JointVector& q, std::size_t reflector = 0) const;

  const TrueArmSetup& setup() const { return setup_; }

 private:
  Eigen::Isometry3d X_BF(const JointVector& q) const;

  TrueArmSetup setup_;
  std::vector<TrueReflector> reflectors_;  // all, their directions normalised
  RobotModel robot_;                       // as warm as it is
  Random random_;
  Eigen::Vector3d deviation_mm_{0, 0, 0};  // in the base frame
  ApproachDirections directions_;
  JointVector stands_at_;  // of the last move
};

}  // namespace truepose
