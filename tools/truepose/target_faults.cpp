#include "tools/truepose/target_faults.hpp"

#include <sstream>

#include "config/joint_columns.hpp"

namespace truepose::tools {

namespace {

std::string beyond_limit(const CompensationFault& fault, const RobotModel& robot) {
  const Joint& joint = robot.joints[static_cast<std::size_t>(fault.joint)];
  const double unit = config::per_file_unit(joint);
  std::ostringstream text;
  text << "joint " << fault.joint + 1 << " would have to go to " << fault.q_wrong / unit
       << (joint.type == JointType::Revolute ? " deg" : " mm") << ", its limits are " << joint.min / unit
       << ".." << joint.max / unit;
  return text.str();
}

}  // namespace

std::string described(const CompensationFault& fault, const RobotModel& robot) {
  switch (fault.kind) {
    case CompensationFault::Kind::DidNotConverge:
      return "the inverse of the calibrated arm did not converge";
    case CompensationFault::Kind::NotFinite:
      return "the inverse of the calibrated arm is not finite";
    case CompensationFault::Kind::BeyondLimit:
      return beyond_limit(fault, robot);
  }
  return {};
}

}  // namespace truepose::tools
