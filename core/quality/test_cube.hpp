#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

#include "core/named.hpp"

namespace truepose {

/// The cube of ISO 9283:1998, 6.8, in the part of the workspace that is used most, its edges parallel to the
/// robot's base where X_BC has no rotation.
///
/// Its corners: C1 to C4 around the upper face (+z), from (+x, -y) over (+x, +y) and (-x, +y) to (-x, -y);
/// C5 to C8 below C1 to C4.
struct TestCube {
  Eigen::Isometry3d X_BC = Eigen::Isometry3d::Identity();  ///< centre and axes in the base frame, mm
  double edge_mm = 0;
};

/// The planes of a cube that a test may lie in, each through two opposite edges (6.8).
enum class DiagonalPlane { C1C2C7C8, C2C3C8C5, C3C4C5C6, C4C1C6C7 };

inline constexpr std::array kPlaneNames{
    Named{"C1-C2-C7-C8", DiagonalPlane::C1C2C7C8},
    Named{"C2-C3-C8-C5", DiagonalPlane::C2C3C8C5},
    Named{"C3-C4-C5-C6", DiagonalPlane::C3C4C5C6},
    Named{"C4-C1-C6-C7", DiagonalPlane::C4C1C6C7},
};

/// C1 to C8, mm, base frame.
std::array<Eigen::Vector3d, 8> cube_corners(const TestCube& cube);

/// P1, the centre, and P2 to P5, a tenth of the diagonal inside the corners of the plane in the order of its
/// name. mm, base frame.
std::array<Eigen::Vector3d, 5> test_positions(const TestCube& cube, DiagonalPlane plane);

}  // namespace truepose
