#include "core/simulate/warm_up.hpp"

#include <cmath>

namespace truepose {

RobotModel warmed(RobotModel cold, const WarmUp& warm_up, Seconds since_start) {
  const double share = -std::expm1(-since_start / warm_up.time_constant);
  for (Eigen::Index i = 0; i < cold.joint_count(); ++i) {
    Joint& joint = cold.joints[static_cast<std::size_t>(i)];
    joint.a_mm *= 1 + share * warm_up.growth;
    joint.d_mm *= 1 + share * warm_up.growth;
    if (warm_up.zero.size() == 0) continue;
    double& zero = joint.type == JointType::Revolute ? joint.theta_rad : joint.d_mm;
    zero += joint.sign * share * warm_up.zero[i];
  }
  return cold;
}

}  // namespace truepose
