#include "proto/record/arm_document.hpp"

#include "core/arm/joint_units.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::record {

Arm Arm::of(const RobotModel& robot) {
  Arm arm{.name = robot.name, .joints = {}, .X_flange = robot.X_flange, .gravity_B = robot.gravity_B};
  for (const Joint& joint : robot.joints) arm.joints.push_back({joint, std::nullopt});
  for (std::size_t i = 0; i < robot.masses.size(); ++i) arm.joints[i].mass = {robot.masses[i]};
  return arm;
}

RobotModel Arm::robot() const {
  RobotModel robot;
  robot.name = name;
  robot.X_flange = X_flange;
  robot.gravity_B = gravity_B;
  for (const ArmJoint& each : joints) {
    robot.joints.push_back(each.joint);
    if (each.mass) robot.masses.push_back(each.mass->mass);
  }
  return robot;
}

boost::json::object arm_document(const RobotModel& robot) { return to_json(Arm::of(robot)); }

boost::json::array joints_json(const JointVector& q, const RobotModel& robot) {
  const std::vector<double> values = in_deg_mm(q, robot);
  return boost::json::array(values.begin(), values.end());
}

}  // namespace truepose::record
