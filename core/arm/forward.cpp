#include "core/arm/forward.hpp"

#include <cassert>
#include <cmath>

#include "core/arm/guide.hpp"
#include "core/arm/joint_coupling.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose {
namespace {

/// Turns two axes of a frame about the third, from a to b.
void turn(double* a, double* b, double angle_rad) {
  const double cos = std::cos(angle_rad), sin = std::sin(angle_rad);
  for (int row = 0; row < 3; ++row) {
    const double before = a[row];
    a[row] = cos * before + sin * b[row];
    b[row] = cos * b[row] - sin * before;
  }
}

/// X times link_transform(), by its turns and shifts one after the other: most joints have no beta.
void apply_joint(const Joint& joint, double q, Eigen::Isometry3d& X) {
  const bool revolute = joint.type == JointType::Revolute;
  const double theta = joint.theta_rad + (revolute ? joint.sign * q : 0.0);
  const double d = joint.d_mm + (revolute ? 0.0 : joint.sign * q);
  double* x = X.matrix().col(0).data();
  double* y = X.matrix().col(1).data();
  double* z = X.matrix().col(2).data();
  double* p = X.matrix().col(3).data();
  if (joint.beta_rad != 0) turn(z, x, joint.beta_rad);
  turn(y, z, joint.alpha_rad);
  for (int row = 0; row < 3; ++row) p[row] += joint.a_mm * x[row] + d * z[row];
  turn(x, y, theta);
}

}  // namespace

Eigen::Isometry3d link_transform(const Joint& joint, double q) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  apply_joint(joint, q, T);
  return T;
}

void link_frames(const RobotModel& robot, const JointVector& q, LinkFrames& X_B) {
  link_frames(robot.joints, robot.coupling, q, X_B);
}

void link_frames(std::span<const Joint> joints, std::span<const JointCoupling> coupling, const JointVector& q,
                 LinkFrames& X_B) {
  assert(q.size() == static_cast<Eigen::Index>(joints.size()));
  const JointVector q_chain = chain_joints(coupling, q);
  X_B[0] = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    X_B[i + 1] = X_B[i];
    apply_joint(joints[i], q_chain[static_cast<Eigen::Index>(i)], X_B[i + 1]);
  }
}

bool is_displaced(const RobotModel& robot) { return robot.field || guided_joints(robot).any(); }

Eigen::Isometry3d displaced(const RobotModel& robot, const JointVector& q, const JointVector& joints,
                            const Eigen::Isometry3d& X_BF) {
  Eigen::Isometry3d X = X_BF;
  if (guided_joints(robot).any()) {
    LinkFrames X_B;
    link_frames(robot, joints, X_B);
    X = displace_by_guides(robot, q, X_B) * X;
  }
  return robot.field ? robot.field->displaced(q, X) : X;
}

Eigen::Isometry3d forward_kinematics(const RobotModel& robot, const JointVector& q, Approach approach) {
  assert(q.size() == robot.joint_count());
  const JointVector joints = true_joints(robot, q, approach);
  const JointVector q_chain = chain_joints(robot.coupling, joints);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    apply_joint(robot.joints[i], q_chain[static_cast<Eigen::Index>(i)], X);
  }
  return displaced(robot, q, joints, X * robot.X_flange);
}

PoseAndJacobian forward_with_jacobian(const RobotModel& robot, const JointVector& q) {
  const JointVector joints = true_joints(robot, q);
  LinkFrames X_B;
  link_frames(robot, joints, X_B);
  PoseAndJacobian out{X_B[robot.joints.size()] * robot.X_flange, JointJacobian::Zero(6, robot.joint_count())};
  const Eigen::Vector3d p = out.X_BF.translation();
  for (Eigen::Index i = 0; i < out.J.cols(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    const Eigen::Isometry3d& X_Bi = X_B[static_cast<std::size_t>(i) + 1];
    const Eigen::Vector3d axis = joint.sign * X_Bi.linear().col(2);
    if (joint.type == JointType::Revolute) {
      out.J.col(i) << axis.cross(p - X_Bi.translation()), axis;
    } else {
      out.J.col(i).head<3>() = axis;
    }
  }
  to_controller_columns(robot.coupling, out.J);
  out.X_BF = displaced(robot, q, joints, out.X_BF);
  return out;
}

}  // namespace truepose
