#include "core/arm/joint_deviation.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/arm/forward.hpp"
#include "core/arm/guide.hpp"
#include "core/arm/joint_coupling.hpp"
#include "core/math/units.hpp"

namespace truepose {
namespace {

constexpr double kKilonewtonsPerKg = 9.80665e-3;

bool bends_under_torque(const RobotModel& robot) {
  return std::ranges::any_of(robot.deviation, [](const DeviationTerm& term) {
    return term.basis == DeviationBasis::Gravity || term.basis == DeviationBasis::Weight ||
           is_moment(term.basis);
  });
}

/// The frames by which torques are computed, where there are any.
void torque_frames(const RobotModel& robot, const JointVector& q, LinkFrames& X_B) {
  const std::vector<Joint>& joints = robot.torque_joints.empty() ? robot.joints : robot.torque_joints;
  if (bends_under_torque(robot)) link_frames(joints, robot.coupling, q, X_B);
}

/// Torque (force times m) about joint i, in the sense of +q, of a unit force along gravity at p_B_mm; for a
/// prismatic joint the force along it.
double moment(const RobotModel& robot, const LinkFrames& X_B, std::size_t i, const Eigen::Vector3d& p_B_mm) {
  const Joint& joint = robot.joints[i];
  const Eigen::Vector3d axis = joint.sign * X_B[i + 1].linear().col(2);
  if (joint.type == JointType::Prismatic) return axis.dot(robot.gravity_B);
  const Eigen::Vector3d lever_mm = p_B_mm - X_B[i + 1].translation();
  return kMetresPerMm * axis.dot(lever_mm.cross(robot.gravity_B));
}

/// Part of the torque about joint i that a mass off the origin of frame `order` adds to that of the mass
/// there, per unit of force and m along an axis of the frame.
double first_moment(const RobotModel& robot, const LinkFrames& X_B, std::size_t i, int order, int axis) {
  const auto frame = static_cast<std::size_t>(order);
  const Eigen::Vector3d about = robot.joints[i].sign * X_B[i + 1].linear().col(2);
  return about.dot(X_B[frame].linear().col(axis).cross(robot.gravity_B));
}

Eigen::Vector3d weight_point(const RobotModel& robot, const LinkFrames& X_B, int order) {
  const auto frame = static_cast<std::size_t>(order);
  if (frame <= robot.joints.size()) return X_B[frame].translation();
  return (X_B[robot.joints.size()] * robot.X_flange).translation();
}

double gravity_torque(const RobotModel& robot, const LinkFrames& X_B, std::size_t i) {
  double torque = 0;
  for (std::size_t k = i; k < robot.masses.size(); ++k) {
    const LinkMass& mass = robot.masses[k];
    torque += kKilonewtonsPerKg * mass.mass_kg * moment(robot, X_B, i, X_B[k + 1] * mass.centre_mm);
  }
  if (!robot.payload) return torque;
  const Eigen::Isometry3d X_BF = X_B[robot.joints.size()] * robot.X_flange;
  return torque +
         kKilonewtonsPerKg * robot.payload->mass_kg * moment(robot, X_B, i, X_BF * robot.payload->centre_mm);
}

/// Value of one term; X_B by torque_frames(), q_chain by chain_joints().
double basis_value(const RobotModel& robot, const LinkFrames& X_B, const JointVector& q_chain,
                   Approach approach, const DeviationTerm& term) {
  const auto i = static_cast<std::size_t>(term.joint);
  switch (term.basis) {
    case DeviationBasis::Sine:
      return std::sin(term.order * q_chain[term.joint]);
    case DeviationBasis::Cosine:
      return std::cos(term.order * q_chain[term.joint]);
    case DeviationBasis::Gravity:
      return gravity_torque(robot, X_B, i);
    case DeviationBasis::Weight:
      return moment(robot, X_B, i, weight_point(robot, X_B, term.order));
    case DeviationBasis::MomentX:
      return first_moment(robot, X_B, i, term.order, 0);
    case DeviationBasis::MomentY:
      return first_moment(robot, X_B, i, term.order, 1);
    case DeviationBasis::MomentZ:
      return first_moment(robot, X_B, i, term.order, 2);
    case DeviationBasis::Approach:
      return i < approach.size() ? approach[i] : 0;
    case DeviationBasis::Scale:
      return kMetresPerMm * q_chain[term.joint];
    case DeviationBasis::ShiftX:
    case DeviationBasis::TurnX:
    case DeviationBasis::ShiftY:
    case DeviationBasis::TurnY:
    case DeviationBasis::TurnZ:
      return half_waves(robot.joints[i], term.order, q_chain[term.joint]);
  }
  return 0;
}

}  // namespace

bool is_moment(DeviationBasis basis) {
  return basis == DeviationBasis::MomentX || basis == DeviationBasis::MomentY ||
         basis == DeviationBasis::MomentZ;
}

void deviation_basis(const RobotModel& robot, const JointVector& q, Approach approach,
                     std::span<double> values) {
  assert(values.size() == robot.deviation.size());
  LinkFrames X_B;
  torque_frames(robot, q, X_B);
  const JointVector q_chain = chain_joints(robot.coupling, q);
  for (std::size_t t = 0; t < values.size(); ++t) {
    values[t] = basis_value(robot, X_B, q_chain, approach, robot.deviation[t]);
  }
}

namespace {

/// @param basis  the value of a term, by its place
template <typename Basis>
JointVector deviated(const RobotModel& robot, const JointVector& q_chain, Basis basis) {
  JointVector out = q_chain;
  const bool guided = guided_joints(robot).any();
  for (std::size_t t = 0; t < robot.deviation.size(); ++t) {
    const DeviationTerm& term = robot.deviation[t];
    if (guided && guide_motion(term.basis) >= 0) continue;
    out[term.joint] += term.coefficient * basis(t);
  }
  return controller_joints(robot.coupling, out);
}

}  // namespace

JointVector true_joints(const RobotModel& robot, const JointVector& q, Approach approach) {
  if (robot.deviation.empty()) return q;
  const JointVector q_chain = chain_joints(robot.coupling, q);
  LinkFrames X_B;
  torque_frames(robot, q, X_B);
  return deviated(robot, q_chain, [&](std::size_t t) {
    return basis_value(robot, X_B, q_chain, approach, robot.deviation[t]);
  });
}

JointVector true_joints(const RobotModel& robot, const JointVector& q, std::span<const double> basis) {
  assert(basis.size() == robot.deviation.size());
  if (robot.deviation.empty()) return q;
  return deviated(robot, chain_joints(robot.coupling, q), [&](std::size_t t) { return basis[t]; });
}

bool bases_follow_links(const RobotModel& robot) {
  return robot.torque_joints.empty() && bends_under_torque(robot);
}

bool moves_along(const RobotModel& robot, const DeviationTerm& term) {
  const int motion = guide_motion(term.basis);
  if (motion >= 0) return !kGuideMotions[static_cast<std::size_t>(motion)].turns;
  return robot.joints[static_cast<std::size_t>(term.joint)].type == JointType::Prismatic;
}

std::string deviation_name(const DeviationTerm& term) {
  const std::string joint = "joint" + std::to_string(term.joint + 1);
  const std::string order = std::to_string(term.order);
  switch (term.basis) {
    case DeviationBasis::Sine:
      return joint + ".sin" + order;
    case DeviationBasis::Cosine:
      return joint + ".cos" + order;
    case DeviationBasis::Gravity:
      return joint + ".gravity";
    case DeviationBasis::Weight:
      return joint + ".weight" + order;
    case DeviationBasis::MomentX:
      return joint + ".momentx" + order;
    case DeviationBasis::MomentY:
      return joint + ".momenty" + order;
    case DeviationBasis::MomentZ:
      return joint + ".momentz" + order;
    case DeviationBasis::Approach:
      return joint + ".approach";
    case DeviationBasis::Scale:
      return joint + ".scale";
    case DeviationBasis::ShiftX:
      return joint + ".shiftx" + order;
    case DeviationBasis::TurnX:
      return joint + ".turnx" + order;
    case DeviationBasis::ShiftY:
      return joint + ".shifty" + order;
    case DeviationBasis::TurnY:
      return joint + ".turny" + order;
    case DeviationBasis::TurnZ:
      return joint + ".turnz" + order;
  }
  return joint;
}

}  // namespace truepose
