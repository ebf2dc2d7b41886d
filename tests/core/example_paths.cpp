#include "tests/core/example_paths.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/arm/pose_inverse.hpp"
#include "core/math/angles.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose::example {
namespace {

/// Within -1 and 1: the place at `k` of `count`.
Eigen::Vector3d place_on(Path path, int k, int count, Random& random) {
  const double along = 2 * (k + 0.5) / count - 1, angle = std::numbers::pi * along;
  const auto in_steps = [&](int step, int steps) { return 2.0 * (step % steps) / (steps - 1) - 1; };
  switch (path) {
    case Path::Line:
      return {along, 0, 0};
    case Path::Circle:
      return {std::cos(angle), std::sin(angle), 0};
    case Path::Plane:
      return {random.uniform(-1, 1), random.uniform(-1, 1), 0};
    case Path::Grid:
      return {in_steps(k, 4), in_steps(k / 4, 4), 0.3 * in_steps(k / 16, 3)};
    case Path::Spline:
      return {along, 0.4 * std::sin(angle), 0.3 * std::sin(2 * angle + 1)};
  }
  std::unreachable();
}

std::optional<std::vector<JointVector>> path_from(const RobotModel& robot, const JointVector& middle,
                                                  Path path, int poses, double turn_rad, Random& random) {
  const bool upright = robot.joint_count() < 6;
  const Eigen::Isometry3d X_BF = forward_kinematics(robot, middle);
  const double size_mm = upright ? 120 : 0.2 * std::max(1000.0, X_BF.translation().norm());
  const Eigen::Matrix3d R_path =
      rotation_zyx(random.uniform(-3, 3), random.uniform(-1, 1), random.uniform(-3, 3));
  std::vector<JointVector> joints;
  for (int k = 0; k < poses; ++k) {
    Eigen::Isometry3d wanted = X_BF;
    wanted.translation() += size_mm * R_path * place_on(path, k, poses, random);
    Eigen::Vector3d turn(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    if (upright) turn.head<2>().setZero();
    wanted.linear() = rotation_by(turn_rad * turn) * X_BF.linear();
    const auto there = inverse_near(robot, wanted, middle);
    if (!there || !within_limits(robot, there->q)) return std::nullopt;
    joints.push_back(there->q);
  }
  return joints;
}

}  // namespace

const char* name_of(Path path) {
  constexpr const char* kNames[] = {"line", "circle", "plane", "grid", "spline"};
  return kNames[static_cast<int>(path)];
}

std::vector<JointVector> along(const RobotModel& robot, Path path, int poses, double turn_rad,
                               Random& random) {
  for (;;) {
    const auto joints = path_from(robot, random_joints(robot, random), path, poses, turn_rad, random);
    if (joints) return *joints;
  }
}

}  // namespace truepose::example
