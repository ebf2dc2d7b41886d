#include "core/arm/guide.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/angles.hpp"

namespace truepose {

int guide_motion(DeviationBasis basis) {
  static_assert([] {
    for (std::size_t m = 0; m < kGuideMotions.size(); ++m)
      if (static_cast<std::size_t>(kGuideMotions[m].basis) !=
          m + static_cast<std::size_t>(DeviationBasis::ShiftX))
        return false;
    return true;
  }());
  return basis < DeviationBasis::ShiftX ? -1
                                        : static_cast<int>(basis) - static_cast<int>(DeviationBasis::ShiftX);
}

std::bitset<kMaxJoints> guided_joints(const RobotModel& robot) {
  std::bitset<kMaxJoints> guided;
  // Most arms have no rail, and many terms to look through.
  const auto slides = [](const Joint& joint) { return joint.type == JointType::Prismatic; };
  if (robot.deviation.empty() || std::ranges::none_of(robot.joints, slides)) return guided;
  for (const DeviationTerm& term : robot.deviation)
    if (guide_motion(term.basis) >= 0) guided.set(static_cast<std::size_t>(term.joint));
  return guided;
}

double half_waves(const Joint& joint, int order, double q) {
  return std::cos(order * std::numbers::pi * (q - joint.min) / (joint.max - joint.min));
}

GuideFrames guide_frames(const RobotModel& robot, int joint, const JointVector& q) {
  std::array<double, kGuideMotions.size()> moved{};
  for (const DeviationTerm& term : robot.deviation) {
    const int motion = guide_motion(term.basis);
    if (term.joint != joint || motion < 0) continue;
    moved[static_cast<std::size_t>(motion)] +=
        term.coefficient * half_waves(robot.joints[static_cast<std::size_t>(joint)], term.order, q[joint]);
  }
  GuideFrames X;
  X[0] = Eigen::Isometry3d::Identity();
  for (std::size_t m = 0; m < kGuideMotions.size(); ++m) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(kGuideMotions[m].axis);
    X[m + 1] = X[m];
    if (kGuideMotions[m].turns) {
      X[m + 1].rotate(Eigen::AngleAxisd(moved[m], axis));
    } else {
      X[m + 1].translate(moved[m] * axis);
    }
  }
  return X;
}

Eigen::Isometry3d displace_by_guides(const RobotModel& robot, const JointVector& q, LinkFrames& X_B) {
  const auto guided = guided_joints(robot);
  Eigen::Isometry3d displacement = Eigen::Isometry3d::Identity();
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    Eigen::Isometry3d& X = X_B[i + 1];
    X = displacement * X;
    if (!guided[i]) continue;
    const Eigen::Isometry3d straight = X;
    X = straight * guide_frames(robot, static_cast<int>(i), q).back();
    displacement = X * inverse_of(straight) * displacement;
  }
  return displacement;
}

Joint link_of_motion(const GuideMotion& motion) {
  Joint link{.type = motion.turns ? JointType::Revolute : JointType::Prismatic};
  // The first about each axis takes z there: from z to x to y and back.
  const bool first = !motion.turns || motion.basis == DeviationBasis::TurnZ;
  if (first) link.beta_rad = link.theta_rad = std::numbers::pi / 2;
  return link;
}

LinkNumbers::LinkNumbers(const RobotModel& robot) {
  const auto guided = guided_joints(robot);
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    of_joint_[i] = count_;
    count_ += guided[i] ? 1 + kMotionsOfGuide : 1;
  }
}

}  // namespace truepose
