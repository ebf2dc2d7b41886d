#include "core/compensation/compensation_fault.hpp"

#include <iomanip>
#include <sstream>

#include "core/kinematics/joint_units.hpp"

namespace truepose {

std::string described(const CompensationFault& fault, const RobotModel& nominal) {
  const Joint& joint = nominal.joints[static_cast<std::size_t>(fault.joint)];
  const double unit = unit_of(joint);
  std::ostringstream text;
  switch (fault.kind) {
    case CompensationFault::Kind::DidNotConverge:
      text << "the calibrated arm cannot reach it: it is at the end of the arm's reach or in a singularity; "
              "move it away from there";
      break;
    case CompensationFault::Kind::NotFinite:
      text << "the inverse of the calibrated arm is not finite";
      break;
    case CompensationFault::Kind::BeyondLimit:
      text << "joint " << fault.joint + 1 << " would have to go to " << fault.q_wrong / unit << ' '
           << unit_name(joint) << ", its limits are " << joint.min / unit << ".." << joint.max / unit;
      break;
    case CompensationFault::Kind::TooFar:
      text << "joint " << fault.joint + 1 << " would have to be corrected by " << std::fixed
           << std::setprecision(1) << fault.too_large / unit << ' ' << unit_name(joint)
           << ": too near to a singularity; move it away from there";
      break;
  }
  return text.str();
}

}  // namespace truepose
