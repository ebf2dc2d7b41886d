#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>

#include "core/evaluation/test_cube.hpp"
#include "core/planning/scene.hpp"

namespace truepose {

/// What is wanted of the poses of an ISO 9283 test; what is left out is chosen.
struct TestCubeWish {
  std::optional<Eigen::Vector3d> centre_mm;  ///< base frame
  Box task;                                  ///< in which a chosen centre is
  std::optional<double> edge_mm;             ///< left out: the greatest of the standard's 1000, 630, 400, 250
  std::optional<Eigen::Matrix3d> orientation;  ///< of the flange, R_BF, at all five
  DiagonalPlane plane = DiagonalPlane::C1C2C7C8;
  std::uint64_t seed = 0;
};

/// The five poses of an ISO 9283 test: the reflector at the positions of its cube, one orientation.
struct TestCubePoses {
  TestCube cube;
  Eigen::Matrix3d R_BF;
  std::array<Eigen::Vector3d, 5> p_B_mm;  ///< of the reflector, P1 to P5
  std::array<JointVector, 5> q;           ///< of the scene's arm there, all on one branch
};

/// Finds a cube of which all five poses can be driven to and measured, by trial around random poses that
/// can: in front of the arm before behind it, the largest first, far from the joint limits before near them.
///
/// @return or one sentence: why there is none
std::expected<TestCubePoses, std::string> place_test_cube(const Scene& scene, const TestCubeWish& wish);

}  // namespace truepose
