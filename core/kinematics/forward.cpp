#include "core/kinematics/forward.hpp"

#include <cassert>
#include <cmath>

#include "core/kinematics/residual_field.hpp"

namespace truepose {

Eigen::Isometry3d link_transform(const Joint& joint, double q) {
  const bool revolute = joint.type == JointType::Revolute;
  const double theta = joint.theta_rad + (revolute ? joint.sign * q : 0.0);
  const double d = joint.d_mm + (revolute ? 0.0 : joint.sign * q);
  const double ca = std::cos(joint.alpha_rad), sa = std::sin(joint.alpha_rad);
  const double cb = std::cos(joint.beta_rad), sb = std::sin(joint.beta_rad);
  const double ct = std::cos(theta), st = std::sin(theta);

  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() << cb * ct + sb * sa * st, -cb * st + sb * sa * ct, sb * ca,  //
      ca * st, ca * ct, -sa,                                               //
      -sb * ct + cb * sa * st, sb * st + cb * sa * ct, cb * ca;
  T.translation() = Eigen::Vector3d(cb, 0, -sb) * joint.a_mm + T.linear().col(2) * d;
  return T;
}

void link_frames(std::span<const Joint> joints, const JointVector& q, LinkFrames& X_B) {
  assert(q.size() == static_cast<Eigen::Index>(joints.size()));
  X_B[0] = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < joints.size(); ++i) {
    X_B[i + 1] = X_B[i] * link_transform(joints[i], q[static_cast<Eigen::Index>(i)]);
  }
}

Eigen::Isometry3d forward_kinematics(const RobotModel& robot, const JointVector& q, Approach approach) {
  assert(q.size() == robot.joint_count());
  const JointVector q_true = true_joints(robot, q, approach);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    X = X * link_transform(robot.joints[i], q_true[static_cast<Eigen::Index>(i)]);
  }
  X = X * robot.X_flange;
  return robot.field ? robot.field->displaced(q, X) : X;
}

PoseAndJacobian forward_with_jacobian(const RobotModel& robot, const JointVector& q) {
  LinkFrames X_B;
  link_frames(robot.joints, true_joints(robot, q), X_B);
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
  if (robot.field) out.X_BF = robot.field->displaced(q, out.X_BF);
  return out;
}

}  // namespace truepose
