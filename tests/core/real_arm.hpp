#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

#include "config/measurement_file.hpp"
#include "config/robot_file.hpp"

namespace truepose {

/// A real arm (ABB IRB 120, three reflectors) and what was measured of it.
struct RealArm {
  RobotModel robot;
  MeasurementData data;
};

/// TRUEPOSE_REAL_DATA names its folder; nothing where there is none.
inline std::optional<RealArm> real_arm() {
  const char* const given = std::getenv("TRUEPOSE_REAL_DATA");
  const std::filesystem::path folder =
      given ? std::filesystem::path{given}
            : std::filesystem::path{TRUEPOSE_SOURCE_DIR} / "../shared/data/irb120";
  if (!exists(folder)) return std::nullopt;
  RealArm arm{.robot = config::load_robot(folder / "robot.yaml"), .data = {}};
  arm.data = config::load_measurements(folder / "measurements.csv", arm.robot);
  return arm;
}

}  // namespace truepose
