#include "tools/sim/coordinates.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace truepose::sim {

using emscon::CoordinateSystem;

namespace {

bool is_spherical(CoordinateSystem system) {
  return system == CoordinateSystem::Scw || system == CoordinateSystem::Scc;
}
bool is_cylindrical(CoordinateSystem system) {
  return system == CoordinateSystem::Ccw || system == CoordinateSystem::Ccc;
}

/// +1 where the horizontal angle runs counter-clockwise.
double turn(CoordinateSystem system) {
  return system == CoordinateSystem::Ccw || system == CoordinateSystem::Scw ? -1 : 1;
}

Eigen::Vector3d axis_signs(CoordinateSystem system) {
  return {system == CoordinateSystem::LhrX ? -1.0 : 1.0, system == CoordinateSystem::LhrY ? -1.0 : 1.0,
          system == CoordinateSystem::LhrZ ? -1.0 : 1.0};
}

/// Partial derivatives of the values by x, y and z.
Eigen::Matrix3d derivatives(CoordinateSystem system, const Eigen::Vector3d& p_mm) {
  if (!is_spherical(system) && !is_cylindrical(system)) return axis_signs(system).asDiagonal();
  const double across = std::hypot(p_mm.x(), p_mm.y()), distance = p_mm.norm();
  const Eigen::RowVector3d horizontal =
      turn(system) / (across * across) * Eigen::RowVector3d{-p_mm.y(), p_mm.x(), 0};
  const Eigen::RowVector3d outwards{p_mm.x() / across, p_mm.y() / across, 0};
  Eigen::Matrix3d by_p;
  if (is_cylindrical(system)) {
    by_p << horizontal, outwards, Eigen::RowVector3d::UnitZ();
  } else {
    by_p << horizontal, (p_mm.z() * outwards - across * Eigen::RowVector3d::UnitZ()) / (distance * distance),
        p_mm.transpose() / distance;
  }
  return by_p;
}

}  // namespace

Eigen::Vector3d in_system(CoordinateSystem system, const Eigen::Vector3d& p_mm) {
  const double horizontal = turn(system) * std::atan2(p_mm.y(), p_mm.x());
  const double across = std::hypot(p_mm.x(), p_mm.y());
  if (is_cylindrical(system)) return {horizontal, across, p_mm.z()};
  if (is_spherical(system)) return {horizontal, std::atan2(across, p_mm.z()), p_mm.norm()};
  return axis_signs(system).cwiseProduct(p_mm);
}

Eigen::Vector3d out_of_system(CoordinateSystem system, const Eigen::Vector3d& values) {
  const double horizontal = turn(system) * values[0];
  const Eigen::Vector3d outwards{std::cos(horizontal), std::sin(horizontal), 0};
  if (is_cylindrical(system)) return values[1] * outwards + values[2] * Eigen::Vector3d::UnitZ();
  if (is_spherical(system))
    return values[2] * (std::sin(values[1]) * outwards + std::cos(values[1]) * Eigen::Vector3d::UnitZ());
  return axis_signs(system).cwiseProduct(values);
}

Eigen::Vector3d std_in_system(CoordinateSystem system, const Eigen::Vector3d& p_mm,
                              const Eigen::Vector3d& std_mm) {
  const Eigen::Vector3d variances = derivatives(system, p_mm).cwiseAbs2() * std_mm.cwiseAbs2();
  return variances.cwiseSqrt();
}

bool is_angle(CoordinateSystem system, Eigen::Index index) {
  return (index == 0 && (is_spherical(system) || is_cylindrical(system))) ||
         (index == 1 && is_spherical(system));
}

}  // namespace truepose::sim
