#include "proto/record/arm_document.hpp"

#include "proto/record/forms.hpp"

namespace truepose::record {

std::string Couplings::fault(const std::vector<JointCoupling>& coupling) const {
  const auto turns = [&](int joint) {
    const auto i = static_cast<std::size_t>(joint);
    return i < joints.size() && joints[i] == JointType::Revolute;
  };
  for (const JointCoupling& each : coupling) {
    const std::string joint = std::to_string(each.joint + 1), to = std::to_string(each.to + 1);
    if (each.to >= each.joint) return "joint " + joint + " to " + to + ": expected a joint before it";
    if (!turns(each.joint) || !turns(each.to))
      return "joint " + joint + " to " + to + ": expected joints of the arm that turn";
  }
  return {};
}

Arm Arm::of(const RobotModel& robot) {
  Arm arm{.name = robot.name,
          .joints = {},
          .coupling = robot.coupling,
          .X_flange = robot.X_flange,
          .payload = robot.payload,
          .gravity_B = robot.gravity_B};
  for (const Joint& joint : robot.joints) arm.joints.push_back({joint, std::nullopt});
  for (std::size_t i = 0; i < robot.masses.size(); ++i) arm.joints[i].mass = {robot.masses[i]};
  return arm;
}

RobotModel Arm::robot() const {
  RobotModel robot;
  robot.name = name;
  robot.coupling = coupling;
  robot.X_flange = X_flange;
  robot.payload = payload;
  robot.gravity_B = gravity_B;
  for (const ArmJoint& each : joints) {
    robot.joints.push_back(each.joint);
    if (each.mass) robot.masses.push_back(each.mass->mass);
  }
  return robot;
}

}  // namespace truepose::record
