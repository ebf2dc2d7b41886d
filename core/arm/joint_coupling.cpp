#include "core/arm/joint_coupling.hpp"

namespace truepose {

// A joint is coupled to joints before it alone: the last goes first there, and the first on the way back.

JointVector chain_joints(std::span<const JointCoupling> coupling, JointVector controller) {
  for (Eigen::Index i = coupling.empty() ? 0 : controller.size(); i-- > 0;)
    for (const JointCoupling& each : coupling)
      if (each.joint == i) controller[i] += each.factor * controller[each.to];
  return controller;
}

JointVector controller_joints(std::span<const JointCoupling> coupling, JointVector chain) {
  for (Eigen::Index i = 0; i < chain.size(); ++i)
    for (const JointCoupling& each : coupling)
      if (each.joint == i) chain[i] -= each.factor * chain[each.to];
  return chain;
}

}  // namespace truepose
