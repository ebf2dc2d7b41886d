#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/math/units.hpp"

namespace truepose {

/// Rz(rz) Ry(ry) Rx(rx), angles in rad. KUKA's A, B, C are rz, ry, rx.
Eigen::Matrix3d rotation_zyx(double rz, double ry, double rx);

/// (rx, ry, rz) in rad with R = Rz(rz) Ry(ry) Rx(rx) and ry in [-pi/2, pi/2]. In the gimbal (ry = +-pi/2) rz
/// is 0.
Eigen::Vector3d angles_zyx(const Eigen::Matrix3d& R);

/// E with omega = E (d rx, d ry, d rz): the angular velocity, in the outer frame, of R = Rz(rz) Ry(ry)
/// Rx(rx). Singular in the gimbal.
Eigen::Matrix3d angle_rates_zyx(const Eigen::Vector3d& rxyz_rad);

/// Pose with the translation (mm) and KUKA's A, B, C (deg).
Eigen::Isometry3d pose_from_kuka(const Eigen::Vector3d& xyz_mm, const Eigen::Vector3d& abc_deg);

/// KUKA's A, B, C (deg) of a rotation.
Eigen::Vector3d kuka_abc_deg(const Eigen::Matrix3d& R);

/// Angle (rad) of the rotation that takes A to B.
double angle_between(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B);

/// v with B = rotation_by(v) A: axis times angle (rad) of the turn from A to B.
Eigen::Vector3d turn_between(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B);

/// The rotation about the axis of `turn` by its length (rad).
Eigen::Matrix3d rotation_by(const Eigen::Vector3d& turn);

/// X^-1. Compiled once: Eigen's own brings inverses of every kind of transformation with it.
Eigen::Isometry3d inverse_of(const Eigen::Isometry3d& X);

/// X p. Eigen's own product makes four rows of p, and a call.
inline Eigen::Vector3d transformed(const Eigen::Isometry3d& X, const Eigen::Vector3d& p) {
  return X.linear() * p + X.translation();
}

}  // namespace truepose
