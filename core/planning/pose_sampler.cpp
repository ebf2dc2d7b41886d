#include "core/planning/pose_sampler.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/kinematics/forward.hpp"
#include "core/random.hpp"

namespace truepose {

namespace {

enum class Verdict { Good, BelowFloor, TurnedAway, TooNear };

constexpr std::array<const char*, 4> kReasons{"", "came below the floor",
                                              "had the reflector turned away from the tracker",
                                              "were too near to another pose"};

/// Range of one joint with the margin kept.
struct Range {
  double min, max;
};

Range range_of(const Joint& joint, const PoseSamplerOptions& options) {
  const double margin =
      joint.type == JointType::Revolute ? options.limit_margin_rad : options.limit_margin_mm;
  return {joint.min + margin, joint.max - margin};
}

/// Whether every joint's frame, the flange and the reflector are above the floor.
///
/// The first joint's frame stands on the base itself: where it is belongs to the pedestal, not to the pose.
bool above_floor(const RobotModel& robot, const JointVector& q, const Eigen::Vector3d& p_BS_mm,
                 double floor_mm) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (int i = 0; i < robot.joint_count(); ++i) {
    X = X * link_transform(robot.joints[static_cast<std::size_t>(i)], q[i]);
    if (i > 0 && X.translation().z() < floor_mm) return false;
  }
  return (X * robot.X_flange).translation().z() >= floor_mm && p_BS_mm.z() >= floor_mm;
}

/// Whether the tracker, at the origin of its frame, is inside the reflector's cone.
bool seen(const LineOfSight& sight, const Eigen::Isometry3d& X_BF) {
  const Eigen::Isometry3d X_WF = sight.X_WB * X_BF;
  const Eigen::Vector3d p_WS_mm = X_WF * sight.p_FS_mm;
  const Eigen::Vector3d facing_W = X_WF.linear() * sight.facing_F.normalized();
  return facing_W.dot(-p_WS_mm.normalized()) >= std::cos(sight.acceptance_rad);
}

bool distinct(const RobotModel& robot, const JointVector& a, const JointVector& b, double distinct_rad) {
  for (int i = 0; i < robot.joint_count(); ++i) {
    const bool revolute = robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
    if (std::abs(a[i] - b[i]) >= (revolute ? distinct_rad : 1000 * distinct_rad)) return true;
  }
  return false;
}

Verdict judge(const RobotModel& robot, const LineOfSight& sight, const PoseSamplerOptions& options,
              const std::vector<JointVector>& poses, const JointVector& q) {
  const Eigen::Isometry3d X_BF = forward_kinematics(robot, q);
  if (!seen(sight, X_BF)) return Verdict::TurnedAway;
  if (!above_floor(robot, q, X_BF * sight.p_FS_mm, options.floor_mm)) return Verdict::BelowFloor;
  for (const JointVector& other : poses) {
    if (!distinct(robot, q, other, options.distinct_rad)) return Verdict::TooNear;
  }
  return Verdict::Good;
}

}  // namespace

std::expected<std::vector<JointVector>, std::string> sample_poses(const RobotModel& robot,
                                                                  const LineOfSight& sight,
                                                                  const PoseSamplerOptions& options) {
  std::vector<Range> ranges;
  for (const Joint& joint : robot.joints) {
    ranges.push_back(range_of(joint, options));
    if (ranges.back().min >= ranges.back().max) {
      return std::unexpected(
          "joint " + std::to_string(ranges.size()) +
          ": nothing is left between its limits once the margin is kept; make the margin smaller");
    }
  }

  Random random{options.seed};
  std::vector<JointVector> poses;
  std::array<int, kReasons.size()> count{};
  for (int tried = 0; tried < options.candidates; ++tried) {
    if (static_cast<int>(poses.size()) == options.poses) return poses;
    JointVector q{robot.joint_count()};
    for (int i = 0; i < robot.joint_count(); ++i) {
      const Range& range = ranges[static_cast<std::size_t>(i)];
      q[i] = random.uniform(range.min, range.max);
    }
    const Verdict verdict = judge(robot, sight, options, poses, q);
    ++count[static_cast<std::size_t>(verdict)];
    if (verdict == Verdict::Good) poses.push_back(q);
  }
  if (static_cast<int>(poses.size()) == options.poses) return poses;

  const auto worst =
      static_cast<std::size_t>(std::max_element(count.begin() + 1, count.end()) - count.begin());
  return std::unexpected("only " + std::to_string(poses.size()) + " of " + std::to_string(options.poses) +
                         " poses found in " + std::to_string(options.candidates) + " tries; " +
                         std::to_string(count[worst]) + " " + kReasons[worst] +
                         ": check the tracker's placement, the reflector's direction and the floor");
}

double travel_time_s(const RobotModel& robot, const JointVector& from, const JointVector& to) {
  double longest = 0;
  for (int i = 0; i < robot.joint_count(); ++i) {
    longest = std::max(longest, std::abs(to[i] - from[i]) / robot.joints[static_cast<std::size_t>(i)].speed);
  }
  return longest;
}

std::vector<JointVector> order_by_travel(const RobotModel& robot, const JointVector& start,
                                         std::vector<JointVector> poses) {
  const JointVector* here = &start;
  for (auto next = poses.begin(); next != poses.end(); ++next) {
    const auto nearest = std::min_element(next, poses.end(), [&](const JointVector& a, const JointVector& b) {
      return travel_time_s(robot, *here, a) < travel_time_s(robot, *here, b);
    });
    std::iter_swap(next, nearest);
    here = &*next;
  }
  return poses;
}

}  // namespace truepose
