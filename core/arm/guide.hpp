#pragma once

#include <array>
#include <bitset>

#include "core/arm/forward.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose {

/// @file
/// The guide of a prismatic joint, whose carriage does not go straight.
///
/// Behind joint i the link's frame is displaced in itself by G = Trans(x) Rot(x) Trans(y) Rot(y) Rot(z), one
/// motion along or about an axis after the other. Each is a sum of coefficient * cos(order * pi * s), with s
/// from 0 to 1 over the joint's limits: smooth, and free at both ends, where sines of the travel would be 0
/// and full waves alike. Along z it is the joint itself that errs. Source: the error motions of a linear
/// axis, ISO 230-1, 3.4: straightness in two directions, roll, pitch, yaw.

/// One of the motions that make up G.
struct GuideMotion {
  DeviationBasis basis;
  int axis;  ///< 0 = x
  bool turns;
};
inline constexpr std::array kGuideMotions{
    GuideMotion{DeviationBasis::ShiftX, 0, false}, GuideMotion{DeviationBasis::TurnX, 0, true},
    GuideMotion{DeviationBasis::ShiftY, 1, false}, GuideMotion{DeviationBasis::TurnY, 1, true},
    GuideMotion{DeviationBasis::TurnZ, 2, true}};
inline constexpr int kMotionsOfGuide = static_cast<int>(kGuideMotions.size());

/// Most joints of an arm whose guides may err: a gantry has three.
inline constexpr int kMostGuides = 3;

/// Which of the motions it is the basis of; -1: of none.
int guide_motion(DeviationBasis basis);
/// Joints whose guides err.
std::bitset<kMaxJoints> guided_joints(const RobotModel& robot);

/// cos(order * pi * s) at joint position q (mm).
double half_waves(const Joint& joint, int order, double q);

/// G of a joint at encoder positions q, motion by motion: the frame before each of them, and G itself last,
/// in the link's frame.
using GuideFrames = std::array<Eigen::Isometry3d, kMotionsOfGuide + 1>;
GuideFrames guide_frames(const RobotModel& robot, int joint, const JointVector& q);

/// Puts link frames where the guides have them. Does not allocate.
///
/// @param q    encoder positions
/// @param X_B  by link_frames(), the joints truly where they are
/// @return displacement of all that is behind the last guide, in the base frame
Eigen::Isometry3d displace_by_guides(const RobotModel& robot, const JointVector& q, LinkFrames& X_B);

/// A motion as a link: where each motion of a guide is a link of its own behind its joint's, what knows links
/// knows guides.
Joint link_of_motion(const GuideMotion& motion);

/// Numbers of the links in such a chain.
class LinkNumbers {
 public:
  explicit LinkNumbers(const RobotModel& robot);
  int count() const { return count_; }
  int of_joint(int i) const { return of_joint_[static_cast<std::size_t>(i)]; }
  /// The one that the term moves.
  int of(const DeviationTerm& term) const { return of_joint(term.joint) + 1 + guide_motion(term.basis); }

 private:
  std::array<int, kMaxJoints> of_joint_{};
  int count_ = 0;
};

}  // namespace truepose
