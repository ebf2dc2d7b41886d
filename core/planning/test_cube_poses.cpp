#include "core/planning/test_cube_poses.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <vector>

#include "core/compensation/pose_inverse.hpp"
#include "core/planning/candidates.hpp"
#include "core/planning/motion.hpp"

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

/// The five poses of a cube, if they can be measured and driven from one to the next.
/// @param q  on the branch that is wanted
std::optional<TestCubePoses> poses_of(const TestCube& cube, const Eigen::Matrix3d& R_BF, DiagonalPlane plane,
                                      const JointVector& q, PoseChecker& checker, MotionChecker& motion) {
  const Scene& scene = checker.scene();
  TestCubePoses poses{cube, R_BF, test_positions(cube, plane), {}};
  for (std::size_t i = 0; i < poses.q.size(); ++i) {
    Eigen::Isometry3d X_BF = Eigen::Isometry3d::Identity();
    X_BF.linear() = R_BF;
    X_BF.translation() = poses.p_B_mm[i] - R_BF * scene.sight.p_FS_mm;
    const auto found = inverse_near(scene.robot, X_BF, i == 0 ? q : poses.q[0]);
    if (!found || checker.fault_of(found->q)) return std::nullopt;
    poses.q[i] = found->q;
  }
  for (std::size_t i = 0; i < poses.q.size(); ++i) {
    if (!motion.clear(poses.q[i], poses.q[(i + 1) % poses.q.size()])) return std::nullopt;
  }
  return poses;
}

std::string no_cube(const TestCubeWish& wish, double edge_mm) {
  char text[300];
  std::snprintf(
      text, sizeof text,
      "no cube with an edge of %.0f mm%s%s was found of whose diagonal plane the tracker sees all five "
      "poses: choose a smaller one, or another place or orientation",
      edge_mm, wish.centre_mm ? " at this centre" : "", wish.orientation ? " in this orientation" : "");
  return text;
}

}  // namespace

std::expected<TestCubePoses, std::string> place_test_cube(const Scene& scene, const TestCubeWish& wish) {
  auto candidates = draw_candidates(scene, {.poses = kTrials, .seed = wish.seed}, 1);
  if (!candidates) return std::unexpected(candidates.error());
  // The standard asks for the part of the workspace that is used most: not where joints are at their ends.
  std::ranges::sort(candidates->poses, {},
                    [&](const JointVector& q) { return nearness_to_limits(scene.robot, q); });
  PoseChecker checker{scene};
  MotionChecker motion{scene};
  std::vector<double> edges{1000, 630, 400, 250};
  if (wish.edge_mm) edges = {*wish.edge_mm};
  const auto around = [&](const JointVector& q, double edge_mm) -> std::optional<TestCubePoses> {
    const Eigen::Isometry3d X_BF = forward_kinematics(scene.robot, q);
    TestCube cube{.edge_mm = edge_mm};
    cube.X_BC.translation() = wish.centre_mm.value_or(X_BF * scene.sight.p_FS_mm);
    if (!wish.centre_mm && !wish.task.holds(cube.X_BC.translation())) return std::nullopt;
    return poses_of(cube, wish.orientation.value_or(X_BF.linear()), wish.plane, q, checker, motion);
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
  return std::unexpected(no_cube(wish, edges.back()));
}

}  // namespace truepose
