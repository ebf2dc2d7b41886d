#include "core/plan/test_cube_poses.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/arm/pose_inverse.hpp"
#include "core/formatted.hpp"
#include "core/plan/candidates.hpp"
#include "core/plan/motion.hpp"

namespace truepose {
namespace {

// Poses around which a cube is tried.
constexpr int kTrials = 300;

/// Whether the first joint, which turns the arm or drives it along its track, is in the middle half of its
/// range: the arm then works in front of where it stands.
bool in_front(const RobotModel& robot, const JointVector& q) {
  const Joint& first = robot.joints.front();
  return std::abs(2 * q[0] - first.min - first.max) < 0.5 * (first.max - first.min);
}

/// How near a joint is to its limits: 0 in the middle, 1 at one of them.
double nearness_to_limits(const RobotModel& robot, const JointVector& q) {
  double nearest = 0;
  for (int i = 0; i < robot.joint_count(); ++i) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
    nearest = std::max(nearest, std::abs(2 * q[i] - joint.min - joint.max) / (joint.max - joint.min));
  }
  return nearest;
}

/// What is asked of the poses of a cube.
struct Checkers {
  PoseChecker pose;
  MotionChecker motion;
};

/// Joints with the reflector there, on the branch of `near`.
std::optional<JointVector> joints_at(const Scene& scene, const Eigen::Matrix3d& R_BF,
                                     const Eigen::Vector3d& p_B_mm, const JointVector& near) {
  Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
  X_BF.linear() = R_BF;
  X_BF.translation() = p_B_mm - R_BF * scene.sight.p_FS_mm;
  const auto found = inverse_near(scene.robot, X_BF, near);
  if (!found) return std::nullopt;
  return found->q;
}

/// From whichever side the way is clear.
std::optional<PointApproach> approach_along(const TestCubePoses& poses, std::size_t point, int axis,
                                            double way_mm, Checkers& check) {
  for (const bool upwards : {true, false}) {
    const Eigen::Vector3d way = (upwards ? way_mm : -way_mm) * Eigen::Vector3d::Unit(axis);
    const auto q = joints_at(check.pose.scene(), poses.R_BF, poses.p_B_mm[point] - way, poses.q[point]);
    if (q && !check.pose.fault_of(*q, Visibility::Regardless) && check.motion.clear(*q, poses.q[point]))
      return PointApproach{point, axis, upwards, *q};
  }
  return std::nullopt;
}

/// Whether all of them are clear.
bool add_approaches(TestCubePoses& poses, double way_mm, Checkers& check) {
  for (const std::size_t point : {3u, 1u, 0u}) {
    for (int axis = 0; axis < 3; ++axis) {
      auto approach = approach_along(poses, point, axis, way_mm, check);
      if (!approach) return false;
      poses.approaches.push_back(*std::move(approach));
    }
  }
  return true;
}

/// The five poses of a cube, if they can be measured and driven from one to the next.
/// @param q  on the branch that is wanted
std::optional<TestCubePoses> poses_of(const TestCube& cube, const Eigen::Matrix3d& R_BF,
                                      const TestCubeRequest& request, const JointVector& q, Checkers& check) {
  TestCubePoses poses{cube, R_BF, test_positions(cube, request.plane), {}, {}};
  for (std::size_t i = 0; i < poses.q.size(); ++i) {
    const auto found = joints_at(check.pose.scene(), R_BF, poses.p_B_mm[i], i == 0 ? q : poses.q[0]);
    if (!found || check.pose.fault_of(*found)) return std::nullopt;
    poses.q[i] = *found;
  }
  for (std::size_t i = 0; i < poses.q.size(); ++i) {
    if (!check.motion.clear(poses.q[i], poses.q[(i + 1) % poses.q.size()])) return std::nullopt;
  }
  if (request.approach_mm > 0 && !add_approaches(poses, request.approach_mm, check)) return std::nullopt;
  return poses;
}

std::string no_cube(const TestCubeRequest& request, double edge_mm) {
  return formatted(
      "no cube with an edge of %.0f mm%s%s has a diagonal plane of five poses that the tracker sees%s: "
      "choose a smaller one, or another place or orientation",
      edge_mm, request.centre_mm ? " at this centre" : "", request.orientation ? " in this orientation" : "",
      request.approach_mm > 0 ? " and the arm comes to P1, P2 and P4 along every axis" : "");
}

}  // namespace

std::expected<TestCubePoses, std::string> place_test_cube(const Scene& scene,
                                                          const TestCubeRequest& request) {
  auto candidates = draw_candidates(scene, {.poses = kTrials, .seed = request.seed}, 1);
  if (!candidates) return std::unexpected(candidates.error());
  // The standard asks for the part of the workspace that is used most: not where joints are at their ends.
  std::ranges::sort(candidates->poses, {},
                    [&](const JointVector& q) { return nearness_to_limits(scene.robot, q); });
  Checkers check{PoseChecker{scene}, MotionChecker{scene}};
  std::vector<double> edges{1000, 630, 400, 250};
  if (request.edge_mm) edges = {*request.edge_mm};
  const auto around = [&](const JointVector& q, double edge_mm) -> std::optional<TestCubePoses> {
    const Eigen::Isometry3d X_BF = forward_kinematics(scene.robot, q);
    TestCube cube{.edge_mm = edge_mm};
    cube.X_BC.translation() = request.centre_mm.value_or(X_BF * scene.sight.p_FS_mm);
    if (!request.centre_mm && !request.task.holds(cube.X_BC.translation())) return std::nullopt;
    return poses_of(cube, request.orientation.value_or(X_BF.linear()), request, q, check);
  };
  // A smaller cube where the arm works says more than a larger one behind it.
  const auto behind = std::ranges::stable_partition(
      candidates->poses, [&](const JointVector& q) { return in_front(scene.robot, q); });
  for (const std::span part : {std::span{candidates->poses.begin(), behind.begin()}, std::span{behind}}) {
    for (const double edge_mm : edges) {
      for (const JointVector& q : part) {
        if (auto poses = around(q, edge_mm)) return *std::move(poses);
      }
    }
  }
  return std::unexpected(no_cube(request, edges.back()));
}

}  // namespace truepose
