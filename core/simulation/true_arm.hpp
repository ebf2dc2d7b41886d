#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "core/kinematics/robot_model.hpp"
#include "core/random.hpp"
#include "core/simulation/non_geometric_errors.hpp"

namespace truepose {

/// How an arm, its base and its reflector really are. mm and rad.
struct TrueArmSetup {
  RobotModel robot;                  ///< with the errors that a calibration has to find
  NonGeometricErrors non_geometric;  ///< compliance, gears and play of the joints; by default none
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::Vector3d p_FS_mm{0, 0, 0};
  Eigen::Vector3d facing_F{0, 0, 1};           ///< direction of the reflector's opening, any length but zero
  double acceptance_rad = 0.5235987755982988;  ///< half angle of the cone in which the beam returns (30 deg)
  double repeatability_mm = 0;                 ///< standard deviation per axis, drawn anew at each stop
};

/// The arm as it really is: given the joints that its controller reads, where the reflector truly stands.
class TrueArm {
 public:
  TrueArm(TrueArmSetup setup, std::uint64_t seed);

  /// The arm came to a stand: it stands a little elsewhere than the last time (ISO 9283 repeatability).
  void stop_anew();

  /// The arm moved and came to a stand: it remembers the direction in which each joint moved. A joint that
  /// did not move keeps its direction.
  void move(const JointVector& from, const JointVector& to);
  /// The same from where the last move ended; the first knows no direction.
  void move_to(const JointVector& q);

  /// Direction in which each joint last moved; empty before the first.
  const ApproachDirections& directions() const { return directions_; }

  /// True centre of the reflector in the tracker frame, with the deviation and the directions of the last
  /// stop.
  Eigen::Vector3d p_WS_mm(const JointVector& q) const;

  /// Whether the beam comes back: the tracker (origin of W) is inside the reflector's acceptance cone, and
  /// the reflector above the floor on which the base stands.
  bool visible(const JointVector& q) const;

  const TrueArmSetup& setup() const { return setup_; }

 private:
  Eigen::Isometry3d X_BF(const JointVector& q) const;

  TrueArmSetup setup_;
  Random random_;
  Eigen::Vector3d deviation_mm_{0, 0, 0};  // in the base frame
  ApproachDirections directions_;
  JointVector stands_at_;  // of the last move
};

}  // namespace truepose
