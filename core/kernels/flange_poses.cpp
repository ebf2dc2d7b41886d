#include "core/kernels/flange_poses.hpp"

#include "core/kinematics/residual_field.hpp"

namespace truepose {

Eigen::Isometry3d FlangePoses::at(const JointVector& q, Approach approach) const {
  const Eigen::Isometry3d X_BF = kernel_.forward(true_joints(robot_, q, approach));
  return robot_.field ? robot_.field->displaced(q, X_BF) : X_BF;
}

}  // namespace truepose
