#include "core/diagnosis/unit_mistakes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/data/other_units.hpp"
#include "core/diagnosis/explanation.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/math/angles.hpp"
#include "core/math/statistics.hpp"

namespace truepose {
namespace {

constexpr double kNoReach_mm = 20;  // the smallest arms reach ten times as far
constexpr double kNoReachInInches_mm = 200;

/// Whether angles read as deg are less than a revolution in rad, and not all zero.
bool are_in_rad(const std::vector<double>& angles_rad) {
  double most_rad = 0;
  for (const double angle : angles_rad) most_rad = std::max(most_rad, std::abs(angle));
  return most_rad > 0 && most_rad < 2 * std::numbers::pi * kRadPerDeg;
}

bool has_angles_in_rad(const RobotModel& arm) {
  std::vector<double> angles;
  for (const Joint& joint : arm.joints)
    angles.insert(angles.end(), {joint.alpha_rad, joint.theta_rad, joint.beta_rad});
  return are_in_rad(angles);
}

std::vector<Eigen::Index> turning_joints(const RobotModel& arm) {
  std::vector<Eigen::Index> turning;
  for (Eigen::Index i = 0; i < arm.joint_count(); ++i) {
    if (arm.joints[static_cast<std::size_t>(i)].type == JointType::Revolute) turning.push_back(i);
  }
  return turning;
}

bool has_joints_in_rad(const RobotModel& arm, std::span<const Measurement> points) {
  std::vector<double> angles;
  for (const Measurement& point : points) {
    for (const Eigen::Index i : turning_joints(arm)) angles.push_back(point.q[i]);
  }
  return are_in_rad(angles);
}

/// Whether every joint that turns stops within a revolution in rad, read as deg.
bool has_limits_in_rad(const RobotModel& arm) {
  return std::ranges::all_of(arm.joints, [](const Joint& joint) {
    const double most = std::max(std::abs(joint.min), std::abs(joint.max));
    return joint.type != JointType::Revolute || most < 1.01 * 2 * std::numbers::pi * kRadPerDeg;
  });
}

Mistake angles_in_rad() {
  return of_robot_file("alpha", {"the angles of the robot file are in rad, not deg", "them converted"},
                       [](RobotModel& arm) {
                         const bool limits = has_limits_in_rad(arm);
                         for (Joint& joint : arm.joints) {
                           for (double* angle : {&joint.alpha_rad, &joint.theta_rad, &joint.beta_rad})
                             *angle *= kDegPerRad;
                           if (!limits || joint.type != JointType::Revolute) continue;
                           joint.min *= kDegPerRad;
                           joint.max *= kDegPerRad;
                         }
                       });
}

Mistake joints_in_rad(const RobotModel& arm) {
  return of_points("q1", {"the joint angles of the measurements are in rad, not deg", "them converted"},
                   [turning = turning_joints(arm)](Measurement& point) {
                     for (const Eigen::Index i : turning) point.q[i] *= kDegPerRad;
                   });
}

Mistake lengths_in(const std::string& unit, double mm) {
  return of_robot_file("a", {"the lengths of the robot file are in " + unit + ", not mm", "them converted"},
                       [mm](RobotModel& arm) {
                         for (Joint& joint : arm.joints) {
                           joint.a_mm *= mm;
                           joint.d_mm *= mm;
                         }
                         arm.X_flange.translation() *= mm;
                       });
}

Mistake points_in(const std::string& unit, double mm) {
  return of_points("x, y, z", {"the points are in " + unit + ", not mm", "them converted"},
                   [mm](Measurement& point) { point.p_WS_mm *= mm; });
}

/// How many times as far as the points the flange is from its middle place.
double times_as_far(const ModelAndPoints& given) {
  std::vector<Measurement> flange = given.points;
  const std::vector<Eigen::Isometry3d> poses = flange_poses(given.arm, given.points);
  for (std::size_t k = 0; k < flange.size(); ++k) flange[k].p_WS_mm = poses[k].translation();
  return median(distances_from_middle(flange)) / median(distances_from_middle(given.points));
}

}  // namespace

UnitMistakes units_by_magnitude(const RobotModel& arm, std::span<const Measurement> points) {
  UnitMistakes shown;
  ModelAndPoints fixed{.arm = arm, .points{points.begin(), points.end()}, .open = {}};
  const auto add = [&](std::vector<Mistake>& of_file, Mistake mistake) {
    mistake.apply_fix(fixed);
    of_file.push_back(std::move(mistake));
  };
  if (has_angles_in_rad(arm)) add(shown.robot, angles_in_rad());
  if (has_no_reach(arm)) {
    add(shown.robot, lengths_in("m", kMmPerMetre));
  } else if (reach_mm(arm) < kNoReachInInches_mm) {
    add(shown.robot, lengths_in("inches", kMmPerInch));
  }
  if (has_joints_in_rad(arm, points)) add(shown.measurements, joints_in_rad(arm));
  const double times = times_as_far(fixed);
  if (times > std::sqrt(kMmPerInch * kMmPerMetre)) {
    add(shown.measurements, points_in("m", kMmPerMetre));
  } else if (times > std::sqrt(kMmPerInch)) {
    add(shown.measurements, points_in("inches", kMmPerInch));
  }
  return shown;
}

std::vector<Mistake> measurement_unit_mistakes(const RobotModel& arm) {
  std::vector<Mistake> mistakes{joints_in_rad(arm)};
  for (const auto& [unit, mm] : kOtherUnits) mistakes.push_back(points_in(unit, mm));
  return mistakes;
}

double reach_mm(const RobotModel& robot) {
  double reach_mm = robot.X_flange.translation().norm();
  for (const Joint& joint : robot.joints) reach_mm += std::abs(joint.a_mm) + std::abs(joint.d_mm);
  return reach_mm;
}

bool has_no_reach(const RobotModel& robot) { return reach_mm(robot) < kNoReach_mm; }

}  // namespace truepose
