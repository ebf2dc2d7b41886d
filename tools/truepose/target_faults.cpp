#include "tools/truepose/target_faults.hpp"

#include <sstream>

#include "config/joint_columns.hpp"

namespace truepose::tools {

std::string described(PoseInverseFault fault) {
  switch (fault) {
    case PoseInverseFault::DidNotConverge:
      return "the inverse of the calibrated arm did not converge";
    case PoseInverseFault::NotFinite:
      return "the inverse of the calibrated arm is not finite";
  }
  return {};
}

std::string beyond_limits(const RobotModel& robot, const JointVector& q) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    const double position = q[static_cast<Eigen::Index>(i)];
    if (position >= joint.min && position <= joint.max) continue;
    const bool revolute = joint.type == JointType::Revolute;
    const double unit = config::per_file_unit(joint);
    std::ostringstream text;
    text << "joint " << i + 1 << " would have to go to " << position / unit << (revolute ? " deg" : " mm")
         << ", its limits are " << joint.min / unit << ".." << joint.max / unit;
    return text.str();
  }
  return {};
}

}  // namespace truepose::tools
