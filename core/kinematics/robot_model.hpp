#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace truepose {

/// Most joints that an arm, its rail and its positioner may have together. Bounded, so that a joint vector
/// never allocates and can be used in the real-time cycle.
inline constexpr int kMaxJoints = 16;

/// Joint positions q1..qN: rad for a revolute joint, mm for a prismatic one, in the controller's own sign
/// convention.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxJoints, 1>;

enum class JointType { Revolute, Prismatic };

/// One joint and the link before it, in modified DH with Hayati's beta (all angles rad, all lengths mm).
///
/// T_i = Rot(y, beta) Rot(x, alpha) Trans(a, 0, 0) Rot(z, theta) Trans(0, 0, d), where a revolute joint turns
/// theta (theta = sign * q + theta_rad) and a prismatic joint moves d (d = sign * q + d_mm). Source: Hayati's
/// extension of Craig's modified DH; eqs 1 to 3 of the method's paper.
struct Joint {
  JointType type = JointType::Revolute;
  double a_mm = 0;
  double alpha_rad = 0;
  double d_mm = 0;
  double theta_rad = 0;
  double beta_rad = 0;
  double sign = 1;
  double min = 0;    ///< lower limit of q (rad or mm)
  double max = 0;    ///< upper limit of q (rad or mm)
  double speed = 0;  ///< greatest speed of q (rad/s or mm/s)
};

/// A serial arm from its base frame B to its flange frame F.
struct RobotModel {
  std::string name;
  std::vector<Joint> joints;                                   ///< base to flange, 1 to kMaxJoints of them
  Eigen::Isometry3d X_flange = Eigen::Isometry3d::Identity();  ///< from the last joint's frame to F

  int joint_count() const { return static_cast<int>(joints.size()); }
};

}  // namespace truepose
