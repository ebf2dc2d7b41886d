#include "core/math/angles.hpp"

#include <cmath>

namespace truepose {

Eigen::Matrix3d rotation_zyx(double rz, double ry, double rx) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(rz, Vector3d::UnitZ()) * AngleAxisd(ry, Vector3d::UnitY()) *
          AngleAxisd(rx, Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Vector3d angles_zyx(const Eigen::Matrix3d& R) {
  // rx is taken from what Rz(rz) leaves over, so that the three angles bring R back even next to the gimbal,
  // where each of rz and rx alone is badly known.
  constexpr double kGimbal = 1e-12;
  const double cos_ry = std::hypot(R(0, 0), R(1, 0));
  const double rz = cos_ry < kGimbal ? 0.0 : std::atan2(R(1, 0), R(0, 0));
  const double s = std::sin(rz), c = std::cos(rz);
  return {std::atan2(s * R(0, 2) - c * R(1, 2), c * R(1, 1) - s * R(0, 1)), std::atan2(-R(2, 0), cos_ry), rz};
}

Eigen::Matrix3d angle_rates_zyx(const Eigen::Vector3d& rxyz_rad) {
  Eigen::Matrix3d E;
  E << rotation_zyx(rxyz_rad.z(), rxyz_rad.y(), 0).col(0), rotation_zyx(rxyz_rad.z(), 0, 0).col(1),
      Eigen::Vector3d::UnitZ();
  return E;
}

Eigen::Isometry3d pose_from_kuka(const Eigen::Vector3d& xyz_mm, const Eigen::Vector3d& abc_deg) {
  const Eigen::Vector3d abc = abc_deg * kRadPerDeg;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() = rotation_zyx(abc.x(), abc.y(), abc.z());
  X.translation() = xyz_mm;
  return X;
}

Eigen::Vector3d kuka_abc_deg(const Eigen::Matrix3d& R) { return angles_zyx(R).reverse() * kDegPerRad; }

double angle_between(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) { return turn_between(A, B).norm(); }

Eigen::Vector3d turn_between(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  const Eigen::Matrix3d R = B * A.transpose();
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d rotation_by(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (!(angle > 0)) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

Eigen::Isometry3d inverse_of(const Eigen::Isometry3d& X) {
  Eigen::Isometry3d inverse = Eigen::Isometry3d::Identity();
  inverse.linear() = X.linear().transpose();
  inverse.translation() = -(inverse.linear() * X.translation());
  return inverse;
}

}  // namespace truepose
