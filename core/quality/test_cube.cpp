#include "core/quality/test_cube.hpp"

namespace truepose {

std::array<Eigen::Vector3d, 8> cube_corners(const TestCube& cube) {
  constexpr std::array<std::array<int, 2>, 4> kAround{{{1, -1}, {1, 1}, {-1, 1}, {-1, -1}}};
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d upper(kAround[i][0], kAround[i][1], 1), lower(kAround[i][0], kAround[i][1], -1);
    corners[i] = cube.X_BC * (cube.edge_mm / 2 * upper);
    corners[i + 4] = cube.X_BC * (cube.edge_mm / 2 * lower);
  }
  return corners;
}

std::array<Eigen::Vector3d, 5> test_positions(const TestCube& cube, DiagonalPlane plane) {
  constexpr double kInside = 0.1;  // of the diagonal; the standard allows 0.08 to 0.12
  // The corners of each plane, where opposite ones are two places apart.
  constexpr std::array<std::array<std::size_t, 4>, 4> kPlanes{
      {{1, 2, 7, 8}, {2, 3, 8, 5}, {3, 4, 5, 6}, {4, 1, 6, 7}}};
  const auto& plane_corners = kPlanes[static_cast<std::size_t>(plane)];
  const std::array<Eigen::Vector3d, 8> corners = cube_corners(cube);
  std::array<Eigen::Vector3d, 5> positions{cube.X_BC.translation()};
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d& corner = corners[plane_corners[i] - 1];
    const Eigen::Vector3d& opposite = corners[plane_corners[(i + 2) % 4] - 1];
    positions[i + 1] = corner + kInside * (opposite - corner);
  }
  return positions;
}

}  // namespace truepose
