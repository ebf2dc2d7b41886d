#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/math/units.hpp"

namespace truepose {

/// What one deg (of a joint that turns) or mm (of one that slides), the units of files and documents, is in
/// the model's unit.
inline double unit_of(const Joint& joint) { return joint.type == JointType::Revolute ? kRadPerDeg : 1.0; }
inline std::string_view unit_name(const Joint& joint) {
  return joint.type == JointType::Revolute ? "deg" : "mm";
}

/// @param deg_mm  as many as the arm has joints
inline JointVector joints_from(std::span<const double> deg_mm, const RobotModel& robot) {
  JointVector q(robot.joint_count());
  for (std::size_t i = 0; i < deg_mm.size(); ++i)
    q[static_cast<Eigen::Index>(i)] = deg_mm[i] * unit_of(robot.joints[i]);
  return q;
}

inline std::vector<double> in_deg_mm(const JointVector& q, const RobotModel& robot) {
  std::vector<double> values;
  for (Eigen::Index i = 0; i < q.size(); ++i)
    values.push_back(q[i] / unit_of(robot.joints[static_cast<std::size_t>(i)]));
  return values;
}

}  // namespace truepose
