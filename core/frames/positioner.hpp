#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "core/frames/frame_readings.hpp"

namespace truepose {

/// Whether a chain carries a workpiece (turntable, tilt and turn) rather than a tool: its flange is the
/// table, its base the root. What is asked of it is where it stands, and its links may well be as drawn.
inline bool is_positioner(const RobotModel& robot) { return robot.joint_count() <= 2; }

/// Where a calibrated positioner stands in the base of a calibrated arm, both seen from one station of the
/// tracker.
///
/// One is calibrated after the other, and that is the joint fit: no reading of the table has to do with the
/// arm, and the root's six numbers are free, so that with the root written in the tracker's frame the normal
/// equations of both fall into two blocks, and with the root written in the arm's base they are the same
/// equations in other unknowns. What is left to do is to carry both covariances along.
struct PositionerRoot {
  Eigen::Isometry3d X_BR = Eigen::Isometry3d::Identity();
  /// By both models. Of a turntable nothing along its axis and about it, where the root is as it was given.
  PoseCovariance covariance = PoseCovariance::Zero();
  /// The table by its nominal chain from X_BR to the table as the model has it: of a turntable a shift and
  /// turn of its axis, else the identity.
  Eigen::Isometry3d X_to_model = Eigen::Isometry3d::Identity();
};

/// @param arm, table  what is known of their parameters; with an empty covariance nothing of sigma
/// @param nominal     the table's data sheet, which the controller reckons by
/// @param X_given     root where the controller has it. Of a turntable no reading tells how the root is
/// turned
///                    about the axis and where along it it lies, as the table's points make up for both:
///                    of all roots that are as good, it is the one nearest to this
PositionerRoot positioner_root(const MeasuringCell& arm, const MeasuringCell& table,
                               const RobotModel& nominal, const Eigen::Isometry3d& X_given);

/// A workpiece that was measured on the table as the model has it (tool_frame() of the table), as the
/// controller has it: on the table where the nominal chain puts it from PositionerRoot::X_BR. Parameters as
/// there.
MeasuredFrame workpiece_frame(const MeasuredFrame& on_table, const MeasuringCell& arm,
                              const MeasuringCell& table, const RobotModel& nominal,
                              const Eigen::Isometry3d& X_given);

/// Why a root cannot stand where it was found: with the sign of a joint wrong it is on its head, or turned by
/// half a turn from where it was given. Empty where it may.
/// @param X_given  none: it is judged by the direction of gravity in both robot files
std::string why_turned(const Eigen::Isometry3d& X_BR, const RobotModel& arm, const RobotModel& nominal,
                       const std::optional<Eigen::Isometry3d>& X_given);

/// Where the flange of a positioner with joints at q is in the base of the arm.
Eigen::Isometry3d table_in_base(const CalibratedCell& arm, const CalibratedCell& table, const JointVector& q);

}  // namespace truepose
