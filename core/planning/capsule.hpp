#pragma once

#include <Eigen/Geometry>

namespace truepose {

/// All points within a radius of a segment: the shape by which bodies are kept apart. mm.
struct Capsule {
  Eigen::Vector3d from_mm{0, 0, 0};
  Eigen::Vector3d to_mm{0, 0, 0};
  double radius_mm = 0;
};

/// The capsule, moved with the frame in which it stands.
inline Capsule operator*(const Eigen::Isometry3d& X, const Capsule& capsule) {
  return {X * capsule.from_mm, X * capsule.to_mm, capsule.radius_mm};
}

/// Distance between the surfaces of two capsules; negative where they overlap: the depth. Either may be a
/// sphere, and with a radius of 0 a segment or a point.
/// Source: Ericson, Real-Time Collision Detection (2005), section 5.1.9.
double distance_mm(const Capsule& a, const Capsule& b);

}  // namespace truepose
