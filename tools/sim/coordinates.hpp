#pragma once

#include <Eigen/Core>

#include "proto/emscon/enums.hpp"

namespace truepose::sim {

/// The three values of a point in one of the tracker's coordinate systems: mm and rad.
///
/// Left-handed systems have one axis reversed. Angles run clockwise or counter-clockwise seen from above.
/// Spherical values are the horizontal angle, the angle from the zenith and the distance, as a public client
/// prints them; the order of the cylindrical ones (angle, distance from the axis, height) is not public, and
/// invented.
Eigen::Vector3d in_system(emscon::CoordinateSystem system, const Eigen::Vector3d& p_mm);
/// The other way, to right-handed Cartesian mm.
Eigen::Vector3d out_of_system(emscon::CoordinateSystem system, const Eigen::Vector3d& values);
/// Standard deviations of those values from those of x, y and z, taken as independent.
Eigen::Vector3d std_in_system(emscon::CoordinateSystem system, const Eigen::Vector3d& p_mm,
                              const Eigen::Vector3d& std_mm);
/// Whether the value with this index is an angle.
bool is_angle(emscon::CoordinateSystem system, Eigen::Index index);

}  // namespace truepose::sim
