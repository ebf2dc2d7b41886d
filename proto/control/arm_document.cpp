#include "proto/control/arm_document.hpp"

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <cstddef>
#include <utility>

#include "core/arm/joint_units.hpp"
#include "core/math/angles.hpp"

namespace truepose::control {
namespace {

namespace json = boost::json;

json::object coordinates_json(const Eigen::Vector3d& p) { return {{"x", p.x()}, {"y", p.y()}, {"z", p.z()}}; }

json::object joint_json(const Joint& joint) {
  return {{"type", joint.type == JointType::Revolute ? "revolute" : "prismatic"},
          {"a", joint.a_mm},
          {"alpha", joint.alpha_rad * kDegPerRad},
          {"d", joint.d_mm},
          {"theta", joint.theta_rad * kDegPerRad},
          {"beta", joint.beta_rad * kDegPerRad},
          {"sign", joint.sign < 0 ? -1 : 1},
          {"min", joint.min / unit_of(joint)},
          {"max", joint.max / unit_of(joint)},
          {"speed", joint.speed / unit_of(joint)}};
}

json::object mass_json(const LinkMass& mass) {
  json::object result = coordinates_json(mass.centre_mm);
  result["kg"] = mass.mass_kg;
  return result;
}

json::object pose_json(const Eigen::Isometry3d& pose) {
  json::object result = coordinates_json(pose.translation());
  const Eigen::Vector3d abc_deg = kuka_abc_deg(pose.linear());
  result["a"] = abc_deg.x();
  result["b"] = abc_deg.y();
  result["c"] = abc_deg.z();
  return result;
}

}  // namespace

json::object arm_document(const RobotModel& robot) {
  json::array joints;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    json::object joint = joint_json(robot.joints[i]);
    if (!robot.masses.empty()) joint["mass"] = mass_json(robot.masses[i]);
    joints.push_back(std::move(joint));
  }
  return {{"name", robot.name},
          {"joints", std::move(joints)},
          {"flange", pose_json(robot.X_flange)},
          {"gravity", coordinates_json(robot.gravity_B)}};
}

json::array joints_json(const JointVector& q, const RobotModel& robot) {
  const std::vector<double> values = in_deg_mm(q, robot);
  return json::array(values.begin(), values.end());
}

}  // namespace truepose::control
