#pragma once

#include <array>
#include <span>

#include "core/arm/joint_deviation.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose {

/// Pose of link frame i in link frame i-1 with the joint itself at q (rad or mm).
/// Source: eq. 1 of the method's paper, beta first.
Eigen::Isometry3d link_transform(const Joint& joint, double q);

/// Poses of the link frames 0 (the base) to N in the base frame, with the joints truly at q (deviations not
/// regarded). Only the first N + 1 are set.
using LinkFrames = std::array<Eigen::Isometry3d, kMaxJoints + 1>;
void link_frames(const RobotModel& robot, const JointVector& q, LinkFrames& X_B);
/// The same of the arm with other links.
void link_frames(std::span<const Joint> joints, std::span<const JointCoupling> coupling, const JointVector& q,
                 LinkFrames& X_B);

/// Whether anything displaces the flange beyond where geometry and joints put it: guides, or a residual
/// field.
bool is_displaced(const RobotModel& robot);
/// Where these put the flange. Does not allocate.
///
/// @param q       encoder positions
/// @param joints  where the joints truly stand, by true_joints()
/// @param X_BF    where geometry and joints put it
Eigen::Isometry3d displaced(const RobotModel& robot, const JointVector& q, const JointVector& joints,
                            const Eigen::Isometry3d& X_BF);

/// Pose X_BF of the flange in the robot base frame, mm, deviations and residual field included. Does not
/// allocate.
///
/// @param q         robot.joint_count() encoder positions
/// @param approach  directions in which the joints last moved, where known
Eigen::Isometry3d forward_kinematics(const RobotModel& robot, const JointVector& q, Approach approach = {});

/// Geometric Jacobian of the flange: 6 x N, rows 0-2 the velocity of the flange's origin (mm per unit of q),
/// rows 3-5 the angular velocity (rad per unit of q), both in the base frame. Non-geometric errors,
/// guides and the residual field change it by about 1e-4 of itself, and are left out of it: a Newton
/// iteration does not feel that.
using JointJacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxJoints>;

struct PoseAndJacobian {
  Eigen::Isometry3d X_BF;
  JointJacobian J;
};
PoseAndJacobian forward_with_jacobian(const RobotModel& robot, const JointVector& q);

}  // namespace truepose
