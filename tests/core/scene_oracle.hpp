#pragma once

#include "core/plan/scene.hpp"

namespace truepose::test {

/// Distance of two capsules' surfaces by the nearest of `points` points along each.
double sampled_distance_mm(const Capsule& a, const Capsule& b, int points);

/// What a pose is like, found by other means than the planner's: every body is a row of spheres, placed by
/// the product of the links' transforms, and the beam a row of points.
struct OracleVerdict {
  bool seen = false;              ///< the tracker is in the reflector's cone
  double clearance_mm = 0;        ///< of the arm from floor, obstacles, tracker and itself
  double beam_clearance_mm = 0;   ///< of the beam from the arm but the reflector's mount, and from obstacles
  double mount_clearance_mm = 0;  ///< of the beam from the mount: the last link and the tool
};
OracleVerdict judge_by_sampling(const Scene& scene, const JointVector& q);

}  // namespace truepose::test
