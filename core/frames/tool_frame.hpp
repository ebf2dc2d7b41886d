#pragma once

#include <Eigen/Core>
#include <expected>
#include <span>
#include <string>

#include "core/frames/frame_readings.hpp"

namespace truepose {

/// How little orientations of the flange tilt that direction of it along which they tell a TCP least; empty
/// where it is enough. Below it what the arm errs, and by what the tracker was moved, stays in the TCP as it
/// is.
///
/// @param turns  R_BF, at least one
std::string too_alike(std::span<const Eigen::Matrix3d> turns);

/// Why readings do not tell a tool on the flange, each point in four orientations or more that are not too
/// alike; touched, the one that stands still. Empty where they do. It is no question of a workpiece on a
/// table, which turns about its axes alone.
std::string why_not_identifiable(const FrameReadings& data, const RobotModel& robot);

/// The tool T in the flange F, by an arm whose true kinematics are known. Its origin is the TCP.
///
/// Where the tracker reads reflectors at points of the tool, one reading tells a point, and others check it.
/// Without a tracker one point that stands still in the base is touched in several orientations: its place is
/// one more unknown, the same for all. Touched by the TCP it is the reading of "origin"; where it lies ahead
/// on the tool's +X axis, of "x"; in the XY plane on the side of +Y, of "xy". So it is linear either way:
/// X_BF p_F = p_B.
///
/// A 6-D target, whose axes are the tool's and whose origin is the TCP, tells the whole frame by one reading.
///
/// @param R_else  orientation (flange to tool) where the TCP alone was measured
/// Errors: those of measured_frame() and tool_turn(), orientations of readings that are of more points than
/// the origin or that others lack, and orientations that vary too little to tell the TCP from the point.
std::expected<MeasuredFrame, std::string> tool_frame(
    const FrameReadings& data, const MeasuringCell& by,
    const Eigen::Matrix3d& R_else = Eigen::Matrix3d::Identity());

/// Fewest orientations of the arm by which a point of the flange is found without a 6-D target: of fewer, one
/// wrong reading is not detected.
inline constexpr int kFewestOrientations = 4;

/// The arm with its flange so moved that a tool which the controller takes to be at X_controller on it is
/// where it truly is, at X_FT: compensation then puts that tool where the nominal arm would have the
/// controller's.
RobotModel with_tool(RobotModel calibrated, const Eigen::Isometry3d& X_FT,
                     const Eigen::Isometry3d& X_controller);

/// Covariance (mm^2, tracker frame) of where an arm at joints q puts a point of the flange: by the model and
/// by what the measured tool, on which the point is and whose errors go with the model's, does not know of
/// it.
///
/// @param p_F_mm  the point; its own place is taken as exact without a `tool`
Eigen::Matrix3d tcp_covariance(const CalibratedCell& cell, const Eigen::MatrixXd& covariance,
                               const JointVector& q, const Eigen::Vector3d& p_F_mm,
                               const MeasuredFrame* tool = nullptr);

}  // namespace truepose
