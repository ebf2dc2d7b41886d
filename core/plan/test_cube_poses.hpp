#pragma once

#include <array>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "core/plan/scene.hpp"
#include "core/quality/test_cube.hpp"

namespace truepose {

/// What is wanted of the poses of an ISO 9283 test; what is left out is chosen.
struct TestCubeRequest {
  std::optional<Eigen::Vector3d> centre_mm;  ///< base frame
  Box task;                                  ///< in which a chosen centre is
  std::optional<double> edge_mm;             ///< left out: the greatest of the standard's 1000, 630, 400, 250
  std::optional<Eigen::Matrix3d> orientation;  ///< of the flange, R_BF, at all five
  DiagonalPlane plane = DiagonalPlane::C1C2C7C8;
  double approach_mm = 0;  ///< by which P1, P2 and P4 are also to be come to along each axis; 0: they are not
  std::uint64_t seed = 0;
};

/// A straight way, or one so short that it nearly is, to a pose along an axis of the base (7.2.3).
struct PointApproach {
  std::size_t point = 0;  ///< 0 is P1
  int axis = 0;
  bool upwards = true;  ///< in the positive direction of the axis
  JointVector q_start;
};

/// The five poses of an ISO 9283 test: the reflector at the positions of its cube, one orientation.
struct TestCubePoses {
  TestCube cube;
  Eigen::Matrix3d R_BF;
  std::array<Eigen::Vector3d, 5> p_B_mm;  ///< of the reflector, P1 to P5
  std::array<JointVector, 5> q;           ///< of the scene's arm there, all on one branch
  std::vector<PointApproach> approaches;  ///< along x, y and z to P4, P2 and P1, where they were asked for
};

/// Finds a cube of which all five poses can be driven to and measured, by trial around random poses that
/// can: in front of the arm before behind it, the largest first, far from the joint limits before near them.
///
/// @return or one sentence: why there is none
std::expected<TestCubePoses, std::string> place_test_cube(const Scene& scene, const TestCubeRequest& request);

}  // namespace truepose
