#pragma once

#include <Eigen/Core>
#include <cmath>

#include "core/arm/robot_model.hpp"

/// Kinematics and angles as the text books write them, to judge core's by: no code of it is used.
namespace truepose::plain {

/// Rotation about axis 0, 1 or 2 (x, y, z).
inline Eigen::Matrix4d turned(int axis, double rad) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  T(i, i) = T(j, j) = std::cos(rad);
  T(j, i) = std::sin(rad);
  T(i, j) = -T(j, i);
  return T;
}

inline Eigen::Matrix4d shifted(const Eigen::Vector3d& p_mm) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topRightCorner<3, 1>() = p_mm;
  return T;
}

/// Flange in the base of an arm of revolute joints, X_flange being the identity.
inline Eigen::Matrix4d flange(const RobotModel& robot, const JointVector& q) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    T = T * turned(1, joint.beta_rad) * turned(0, joint.alpha_rad) * shifted({joint.a_mm, 0, 0}) *
        turned(2, joint.sign * q[i] + joint.theta_rad) * shifted({0, 0, joint.d_mm});
  }
  return T;
}

/// KUKA's frame {X x, Y y, Z z, A a, B b, C c}, mm and deg: Rz(a) Ry(b) Rx(c).
inline Eigen::Matrix4d kuka_frame(const Eigen::Vector3d& xyz_mm, const Eigen::Vector3d& abc_deg) {
  const Eigen::Vector3d rad = abc_deg * std::acos(-1.0) / 180;
  return shifted(xyz_mm) * turned(2, rad[0]) * turned(1, rad[1]) * turned(0, rad[2]);
}

inline Eigen::Vector3d moved(const Eigen::Matrix4d& T, const Eigen::Vector3d& p) {
  return (T * p.homogeneous()).head<3>();
}

inline double mm_between(const Eigen::Matrix4d& A, const Eigen::Matrix4d& B) {
  return (A - B).topRightCorner<3, 1>().norm();
}

/// Angle between the orientations, rad, where it is small.
inline double rad_between(const Eigen::Matrix4d& A, const Eigen::Matrix4d& B) {
  return (A - B).topLeftCorner<3, 3>().norm() / std::sqrt(2.0);
}

}  // namespace truepose::plain
