#include "core/quality/test_cube.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/angles.hpp"
#include "core/math/rigid_fit.hpp"

namespace truepose {
namespace {

TestCube cube() { return {.X_BC = pose_from_kuka({1500, -200, 1100}, {30, 10, -5}), .edge_mm = 800}; }

TEST(Cube, HasItsNamedCornersWhereTheyAreSaidToBe) {
  const auto corners = cube_corners({.edge_mm = 2});
  EXPECT_EQ(corners[0], Eigen::Vector3d(1, -1, 1));
  EXPECT_EQ(corners[1], Eigen::Vector3d(1, 1, 1));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(corners[i] - corners[i + 4], Eigen::Vector3d(0, 0, 2)) << i;
}

TEST(Cube, PutsItsPointsOnTheDiagonalsOfEachPlane) {
  const double diagonal = 800 * std::sqrt(3.0);
  const auto corners = cube_corners(cube());
  const std::array<std::array<std::size_t, 4>, 4> planes{
      {{0, 1, 6, 7}, {1, 2, 7, 4}, {2, 3, 4, 5}, {3, 0, 5, 6}}};
  for (std::size_t plane = 0; plane < 4; ++plane) {
    const auto p = test_positions(cube(), static_cast<DiagonalPlane>(plane));
    EXPECT_LT((p[0] - Eigen::Vector3d(1500, -200, 1100)).norm(), 1e-9);
    EXPECT_NEAR((p[1] - p[3]).norm(), 0.8 * diagonal, 1e-9);
    EXPECT_NEAR((p[2] - p[4]).norm(), 0.8 * diagonal, 1e-9);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR((p[i + 1] - corners[planes[plane][i]]).norm(), 0.1 * diagonal, 1e-9) << plane << " " << i;
    const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    for (const Eigen::Vector3d& point : p) EXPECT_NEAR(normal.dot(point - p[0]), 0, 1e-9);
  }
}

TEST(RigidFit, FindsTheMotionAndNeverAMirror) {
  const Eigen::Isometry3d X = pose_from_kuka({10, 20, 30}, {170, 89, -100});
  const std::vector<Eigen::Vector3d> from{{0, 0, 0}, {100, 0, 0}, {0, 50, 0}};  // in a plane
  std::vector<Eigen::Vector3d> to;
  for (const Eigen::Vector3d& p : from) to.push_back(X * p);
  const auto fit = rigid_fit(from, to);
  ASSERT_TRUE(fit) << fit.error();
  EXPECT_LT((fit->matrix() - X.matrix()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(RigidFit, RefusesPointsThatShowNoTurn) {
  const std::vector<Eigen::Vector3d> two{{0, 0, 0}, {1, 0, 0}}, line{{0, 0, 0}, {1, 1, 0}, {2, 2, 0}};
  EXPECT_FALSE(rigid_fit(two, two));
  ASSERT_FALSE(rigid_fit(line, line));
  EXPECT_EQ(rigid_fit(line, line).error(), "the points are on one line and do not show a rotation about it");
}

}  // namespace
}  // namespace truepose
