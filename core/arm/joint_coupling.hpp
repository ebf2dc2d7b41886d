#pragma once

#include <span>

#include "core/arm/robot_model.hpp"

namespace truepose {

/// @name A JointVector holds what the controller shows
/// Where its joints are coupled, the joints of the chain of links stand elsewhere. Only what evaluates the
/// chain goes through these. Linear, so they hold for differences too. They do not allocate.
/// @{
JointVector chain_joints(std::span<const JointCoupling> coupling, JointVector controller);
JointVector controller_joints(std::span<const JointCoupling> coupling, JointVector chain);

/// Makes derivatives to the controller's joints of those to the chain's, one column a joint.
template <typename Columns>
void to_controller_columns(std::span<const JointCoupling> coupling, Columns& J) {
  for (Eigen::Index i = 0; i < J.cols(); ++i)
    for (const JointCoupling& each : coupling)
      if (each.to == i) J.col(i) += each.factor * J.col(each.joint);  // behind i, so not changed yet
}
/// @}

}  // namespace truepose
