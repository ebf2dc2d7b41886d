#include "core/quality/arm_identity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/arm/forward.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"

namespace truepose {

namespace {

constexpr double kTip_mm = 100;

/// By how much joint i has to be turned (rad; prismatic: moved, mm) for the flange to come to the
/// controller's.
double zero_shift(const RobotModel& nominal, std::size_t i, const ControllerPose& pose) {
  LinkFrames X_B;
  link_frames(nominal, pose.q, X_B);
  const Eigen::Isometry3d& X_BI = X_B[i + 1];
  const Eigen::Isometry3d X_IF = X_BI.inverse() * forward_kinematics(nominal, pose.q);
  const Eigen::Isometry3d turn = X_BI.inverse() * pose.X_BF * X_IF.inverse();
  if (nominal.joints[i].type == JointType::Prismatic) return turn.translation().z();
  const Eigen::Matrix3d& R = turn.linear();
  return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
}

std::string zero_text(const Joint& joint, double shift) {
  return joint.type == JointType::Revolute ? formatted(" has its zero %.2f deg off", shift * kDegPerRad)
                                           : formatted(" has its zero %.2f mm off", shift);
}

}  // namespace

double flange_deviation_mm(const Eigen::Isometry3d& A, const Eigen::Isometry3d& B) {
  double largest = (A.translation() - B.translation()).norm();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d tip = kTip_mm * Eigen::Vector3d::Unit(axis);
    largest = std::max(largest, (A * tip - B * tip).norm());
  }
  return largest;
}

double largest_deviation_mm(const RobotModel& nominal, std::span<const ControllerPose> poses) {
  double largest = 0;
  for (const ControllerPose& pose : poses) {
    const double off_mm = flange_deviation_mm(pose.X_BF, forward_kinematics(nominal, pose.q));
    if (!(off_mm <= std::numeric_limits<double>::max())) return std::numeric_limits<double>::quiet_NaN();
    largest = std::max(largest, off_mm);
  }
  return largest;
}

std::vector<JointMistake> joint_mistakes(const RobotModel& nominal, std::span<const ControllerPose> poses,
                                         double tolerance_mm) {
  const auto off_mm = [&](const ControllerPose& pose) { return largest_deviation_mm(nominal, {&pose, 1}); };
  const auto worst = std::ranges::max_element(poses, {}, off_mm);
  std::vector<JointMistake> found;
  for (std::size_t i = 0; i < nominal.joints.size(); ++i) {
    const std::string name = "joint " + std::to_string(i + 1);
    const auto explains = [&](const RobotModel& other) {
      return largest_deviation_mm(other, poses) <= tolerance_mm;
    };
    RobotModel turned = nominal;
    turned.joints[i].sign *= -1;
    if (explains(turned)) found.push_back({static_cast<int>(i), name + " turns the other way"});
    const double shift = zero_shift(nominal, i, *worst);
    RobotModel shifted = nominal;
    Joint& joint = shifted.joints[i];
    (joint.type == JointType::Revolute ? joint.theta_rad : joint.d_mm) += shift;
    if (explains(shifted)) found.push_back({static_cast<int>(i), name + zero_text(joint, shift)});
  }
  return found;
}

}  // namespace truepose
