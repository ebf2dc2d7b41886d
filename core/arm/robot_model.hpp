#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace truepose {

/// Most joints that an arm, its rail and its positioner may have together. Bounded, so that a joint vector
/// never allocates and can be used in the real-time cycle.
inline constexpr int kMaxJoints = 16;

/// Joint positions q1..qN: rad for a revolute joint, mm for a prismatic one, as the controller shows them:
/// its own signs, its own couplings.
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
  double min = 0;           ///< lower limit of q (rad or mm)
  double max = 0;           ///< upper limit of q (rad or mm)
  double speed = 0;         ///< greatest speed of q (rad/s or mm/s)
  double acceleration = 0;  ///< greatest acceleration of q (rad/s^2 or mm/s^2); 0 = not known: at once
};

/// A joint that does not stand where the controller shows it, because another one moves it too (an angle
/// counted from the horizon, a parallelogram, a wrist driven through the joints before it): in the chain of
/// links it stands at its own q + factor * q of joint `to`. Both turn.
struct JointCoupling {
  int joint = 0;  ///< index, 0 = first
  int to = 0;     ///< index of a joint before it
  double factor = 1;

  friend bool operator==(const JointCoupling&, const JointCoupling&) = default;
};

/// What a joint's deviation from its encoder depends on.
enum class DeviationBasis {
  Sine,     ///< sin(order * q) of the joint's own position (rad): gear and encoder eccentricity
  Cosine,   ///< cos(order * q)
  Gravity,  ///< torque of payload and known masses outboard about the joint, kN m: compliance
  Weight,   ///< torque of a unit force at the origin of link frame `order` (joint count + 1: the flange), m
  MomentX,  ///< torque of a weight of unit force 1 m along x of link frame `order`, about that frame's origin
  MomentY,  ///< along y
  MomentZ,  ///< along z
  Approach,  ///< direction in which the joint last moved (-1, 1; 0 = unknown): backlash
  Scale,     ///< q itself (m) of a prismatic joint: pitch
  ShiftX,    ///< `order` half waves over the joint's travel, which shift the carriage, see guide.hpp
  TurnX,     ///< or turn it
  ShiftY,
  TurnY,
  TurnZ,
};

/// One term of a joint's deviation: true position = encoder + sum of coefficient * basis. Those of a guide
/// displace the link instead.
struct DeviationTerm {
  int joint = 0;  ///< index, 0 = first
  DeviationBasis basis = DeviationBasis::Sine;
  int order = 1;
  double coefficient = 0;  ///< rad (mm where it moves along) per unit of the basis

  friend bool operator==(const DeviationTerm&, const DeviationTerm&) = default;
};

/// Mass that moves with a link, or with the flange.
struct LinkMass {
  double mass_kg = 0;
  Eigen::Vector3d centre_mm{0, 0, 0};  ///< in the frame of the link or flange

  friend bool operator==(const LinkMass&, const LinkMass&) = default;
};

class ResidualField;

/// A serial arm from its base frame B to its flange frame F.
///
/// A data sheet's arm is geometry alone. A calibrated one may deviate beyond it: its joints from their
/// encoders, and the flange by a field over the joint positions.
struct RobotModel {
  std::string name;
  std::vector<Joint> joints;                                   ///< base to flange, 1 to kMaxJoints of them
  std::vector<JointCoupling> coupling;                         ///< of the controller's joints, mostly none
  Eigen::Isometry3d X_flange = Eigen::Isometry3d::Identity();  ///< from the last joint's frame to F

  std::vector<LinkMass> masses;  ///< one per joint, or empty: not known
  /// What the flange carries; nothing: not known, or among the masses.
  std::optional<LinkMass> payload;
  /// The data sheet's joints, by which gravity torques are computed, so that these do not change while the
  /// arm is identified; empty: `joints`.
  std::vector<Joint> torque_joints;
  Eigen::Vector3d gravity_B{0, 0, -1};         ///< direction of gravity in the base frame, unit length
  std::vector<DeviationTerm> deviation;        ///< none on a nominal arm
  std::shared_ptr<const ResidualField> field;  ///< null on a nominal arm

  int joint_count() const { return static_cast<int>(joints.size()); }
};

/// Whether every joint of `q` is a number within its limits.
inline bool within_limits(const RobotModel& robot, const JointVector& q) {
  for (int i = 0; i < robot.joint_count(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    if (!(q[i] >= joint.min && q[i] <= joint.max)) return false;
  }
  return true;
}

/// What is left of a calibrated arm's error once its parameters are known: a small displacement of the
/// flange for every joint position. Used by the real-time cycle: does not allocate, throw or lock.
class ResidualField {
 public:
  virtual ~ResidualField() = default;

  /// Where the flange truly is.
  ///
  /// @param q     encoder positions
  /// @param X_BF  where the parameters put it
  virtual Eigen::Isometry3d displaced(const JointVector& q, const Eigen::Isometry3d& X_BF) const noexcept = 0;

  /// How well it knows where a point of the flange truly is: covariance, mm^2, base frame. May allocate.
  ///
  /// @param X_BF  as above
  /// @param p_F_mm  the point, in the flange frame
  virtual Eigen::Matrix3d covariance(const JointVector& q, const Eigen::Isometry3d& X_BF,
                                     const Eigen::Vector3d& p_F_mm) const = 0;
};

}  // namespace truepose
