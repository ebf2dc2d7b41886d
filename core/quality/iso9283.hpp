#pragma once

#include <Eigen/Geometry>
#include <expected>
#include <span>
#include <string>
#include <vector>

#include "core/quality/pose_characteristics.hpp"

namespace truepose {

/// Cycles that ISO 9283:1998 asks for at each pose (its table of test conditions for AP, RP and vAP).
inline constexpr int kIso9283Cycles = 30;

/// A pose that a robot came to in one cycle of a test.
struct AttainedPose {
  TestPose pose;
  std::string direction;  ///< from which it came, for the variation; empty: from the pose before
  std::string series;     ///< of cycles, for the drift; empty where there is one
};

/// One of the poses of a test, P1 to P5.
struct TestPoint {
  std::string name;
  TestPose commanded;
  std::vector<AttainedPose> attained;  ///< series in the order of time
};

/// The cycles of one point from one direction in one series, and what they show.
struct CycleSet {
  std::size_t point = 0;  ///< index
  std::string direction, series;
  int cycles = 0;
  TestPose mean;
  SeriesCharacteristics characteristics;
};

struct PointVariation {
  std::size_t point = 0;
  std::string series;
  std::vector<std::string> directions;
  AccuracyVariation variation;
};

struct PointDrift {
  std::size_t point = 0;
  std::string direction;
  std::vector<std::string> series;
  PoseDrift drift;
};

struct Iso9283Result {
  std::vector<CycleSet> sets;
  std::vector<PointVariation> variations;  ///< of points approached from several directions that are named
  std::vector<PointDrift> drifts;          ///< of points measured in several series
  int fewest_cycles = 0;                   ///< of any set; the standard asks for kIso9283Cycles
};

/// AP and RP of each set of cycles, vAP over the directions, dAP and dRP over the series.
///
/// Errors: a set of one cycle, which has no repeatability, named.
std::expected<Iso9283Result, std::string> evaluate_iso9283(std::span<const TestPoint> points);

/// The measuring frame M in the robot's base, X_BM, that brings the mean attained positions nearest to the
/// commanded ones. AP is then relative: the fit takes up what is common to all points.
///
/// Errors: as rigid_fit().
std::expected<Eigen::Isometry3d, std::string> fitted_frame(std::span<const TestPoint> points);

/// Attained poses measured in frame M, brought into the base.
std::vector<TestPoint> in_base(std::vector<TestPoint> points, const Eigen::Isometry3d& X_BM);

}  // namespace truepose
