#pragma once

#include <Eigen/Core>
#include <expected>
#include <string>
#include <vector>

#include "core/frames/frame_readings.hpp"

namespace truepose {

/// How a tool is turned on the flange, as a 6-D target says whose axes are the tool's. One reading tells it,
/// and others check it.
struct ToolTurn {
  Eigen::Matrix3d R_FT = Eigen::Matrix3d::Identity();
  /// Of a turn about each axis by the readings' noise, rad; larger where they scatter more than that.
  double sigma_rad = 0;
  Eigen::Matrix3Xd by_parameters;  ///< derivative of a small turn about the flange's axes to the cell's
  std::vector<double> error_rad;   ///< of each reading, from where all together say
  std::vector<double> sigmas;      ///< as PointFit has them
};

/// Whether readings have orientations.
bool is_turned(const FrameReadings& data);

/// The same readings as of a plain reflector.
FrameReadings without_orientations(FrameReadings data);

/// The weighted mean of what each reading says.
///
/// @param data  readings that each have joints and an orientation
/// Errors: orientations that do not follow the arm.
std::expected<ToolTurn, std::string> tool_turn(const FrameReadings& data, const MeasuringCell& by);

}  // namespace truepose
