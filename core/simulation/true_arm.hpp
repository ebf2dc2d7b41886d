#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "core/kinematics/robot_model.hpp"
#include "core/random.hpp"

namespace truepose {

/// How an arm, its base and its reflector really are. mm and rad.
struct TrueArmSetup {
  RobotModel robot;  ///< with the errors that a calibration has to find
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

  /// True centre of the reflector in the tracker frame, with the deviation of the last stop.
  Eigen::Vector3d p_WS_mm(const JointVector& q) const;

  /// Whether the beam comes back: the tracker (origin of W) is inside the reflector's acceptance cone, and
  /// the reflector above the floor on which the base stands.
  bool visible(const JointVector& q) const;

  const TrueArmSetup& setup() const { return setup_; }

 private:
  TrueArmSetup setup_;
  Random random_;
  Eigen::Vector3d deviation_mm_{0, 0, 0};  // in the base frame
};

}  // namespace truepose
