#pragma once

#include <expected>
#include <string>

#include "core/frames/frame_readings.hpp"

namespace truepose {

/// The TCP by which a work frame's points are touched.
struct TouchingTool {
  Eigen::Vector3d p_F_mm{0, 0, 0};
  const MeasuredFrame* measured = nullptr;  ///< what is known of it; null: taken as exact
};

/// A work frame (KUKA's base) in the robot base B: by points that an arm whose true kinematics are known
/// touches with its TCP, or that the tracker reads. Its covariance is of where the tracker has it, as that of
/// every prediction of the arm is.
///
/// Errors: those of measured_frame().
std::expected<MeasuredFrame, std::string> work_frame(const FrameReadings& data, const MeasuringCell& by,
                                                     const TouchingTool& tool);

}  // namespace truepose
