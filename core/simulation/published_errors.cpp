#include "core/simulation/published_errors.hpp"

#include <cassert>

namespace truepose {

RobotModel with_published_errors(RobotModel nominal) {
  assert(nominal.joints.size() == kPublishedErrors.size());
  for (std::size_t i = 0; i < kPublishedErrors.size(); ++i) {
    Joint& joint = nominal.joints[i];
    const LinkErrors& errors = kPublishedErrors[i];
    joint.a_mm += errors.a_mm;
    joint.alpha_rad += errors.alpha_rad;
    joint.d_mm += errors.d_mm;
    joint.theta_rad += errors.theta_rad;
    joint.beta_rad += errors.beta_rad;
  }
  return nominal;
}

}  // namespace truepose
