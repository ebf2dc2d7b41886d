#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "config/cell_config.hpp"
#include "core/arm/forward.hpp"
#include "proto/rsi/frame_codec.hpp"

namespace truepose {

/// What a healthy controller sends of the shipped arm.
inline rsi::RobotFrame healthy_frame(const config::CellConfig& cell, std::uint64_t cycle) {
  const rsi::Axes axes{0.1, -1.5, 1.5, 0.2, 0.4, -0.3};
  const Eigen::Vector3d p_BF_mm =
      forward_kinematics(cell.robot.model, Eigen::Map<const Eigen::Vector<double, 6>>(axes.data()))
          .translation();
  const rsi::CartesianPose pose{.x_mm = p_BF_mm.x(), .y_mm = p_BF_mm.y(), .z_mm = p_BF_mm.z()};
  return {.ipoc = 4 * cycle,
          .rist = pose,
          .rsol = pose,
          .aipos_rad = axes,
          .aspos_rad = axes,
          .delay = 0,
          .program = {.ask = 1,
                      .state = rsi::kProgramActive,
                      .mode = rsi::kModeExt,
                      .override_percent = 100,
                      .cell = 1024}};
}

inline std::string wire(const rsi::RobotFrame& frame, int decimals = 4) {
  std::array<char, rsi::kMaxFrameBytes> buffer;
  return std::string{encode_robot_frame(frame, buffer, decimals).value()};
}

}  // namespace truepose
