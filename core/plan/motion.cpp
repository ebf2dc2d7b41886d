#include "core/plan/motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/math/angles.hpp"
#include "core/plan/tour.hpp"

namespace truepose {
namespace {

constexpr double kLongestStep_rad = 5 * kRadPerDeg, kShortestStep_rad = 0.5 * kRadPerDeg;
// Stopovers that are tried in pairs: all pairs would take too long.
constexpr std::size_t kMostPaired = 12;
constexpr double kLeavingStep_mm = 5;
// Joints are read as rounded values.
constexpr double kNoNearer_mm = 0.5;

double reach_mm(const RobotModel& robot) {
  double reach = robot.X_flange.translation().norm();
  for (const Joint& joint : robot.joints) reach += std::hypot(joint.a_mm, joint.d_mm);
  return reach;
}

/// Half a step moves no point of the arm farther than the clearance that is kept.
double step_rad(const Scene& scene) {
  return std::clamp(2 * scene.surroundings.clearance_mm / reach_mm(scene.robot), kShortestStep_rad,
                    kLongestStep_rad);
}

double largest_move_rad(const RobotModel& robot, const JointVector& from, const JointVector& to) {
  double largest = 0;
  for (int i = 0; i < robot.joint_count(); ++i) {
    const bool revolute = robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
    largest = std::max(largest, std::abs(to[i] - from[i]) / (revolute ? 1 : 1000));
  }
  return largest;
}

}  // namespace

MotionChecker::MotionChecker(Scene scene)
    : checker_{std::move(scene)}, step_rad_{step_rad(checker_.scene())} {}

bool MotionChecker::clear(const JointVector& from, const JointVector& to) {
  const auto leaves = first_clear(from, to);
  if (!leaves) return false;
  const auto comes = first_clear(to, from);
  if (!comes) return false;
  const JointVector way = to - from;
  const int steps = 1 + static_cast<int>(largest_move_rad(checker_.scene().robot, from, to) / step_rad_);
  const double change_mm = checker_.largest_change_mm(way) / steps;
  const int first = static_cast<int>(std::ceil(*leaves * steps));
  const int last = static_cast<int>(std::floor((1 - *comes) * steps));
  for (int step = first; step < last; ++step) {
    const double spare = checker_.spare_mm(from + static_cast<double>(step) / steps * way);
    if (spare < 0) return false;
    // So many more cannot have used it up.
    step += spare < change_mm * steps ? static_cast<int>(spare / change_mm) : steps;
  }
  return true;
}

std::optional<double> MotionChecker::first_clear(const JointVector& from, const JointVector& to) {
  const JointVector way = to - from;
  const double there_mm = checker_.spare_mm(from);
  if (there_mm >= 0) return 0;
  const int steps = 1 + static_cast<int>(checker_.largest_change_mm(way) / kLeavingStep_mm);
  for (int step = 1; step <= steps; ++step) {
    const double part = static_cast<double>(step) / steps;
    const double spare_mm = checker_.spare_mm(from + part * way);
    if (spare_mm >= 0) return part;
    if (spare_mm < there_mm - kNoNearer_mm) return std::nullopt;
  }
  return std::nullopt;
}

std::optional<std::vector<JointVector>> MotionChecker::way(const JointVector& from, const JointVector& to,
                                                           std::span<const JointVector> stopovers) {
  if (clear(from, to)) return std::vector<JointVector>{};
  const RobotModel& robot = checker_.scene().robot;
  const auto time_s = [&](const JointVector& via) {
    return travel_time_s(robot, from, via) + travel_time_s(robot, via, to);
  };
  std::vector<std::pair<double, const JointVector*>> nearest;
  for (const JointVector& via : stopovers) {
    if (!checker_.collision_at(via)) nearest.emplace_back(time_s(via), &via);
  }
  std::ranges::sort(nearest);
  for (const auto& [time, via] : nearest) {
    if (clear(from, *via) && clear(*via, to)) return std::vector{*via};
  }
  std::vector<const JointVector*> out, in;
  for (const auto& [time, via] : nearest) {
    if (out.size() < kMostPaired && clear(from, *via)) out.push_back(via);
    if (in.size() < kMostPaired && clear(*via, to)) in.push_back(via);
  }
  for (const JointVector* a : out) {
    for (const JointVector* b : in) {
      if (clear(*a, *b)) return std::vector{*a, *b};
    }
  }
  return std::nullopt;
}

}  // namespace truepose
