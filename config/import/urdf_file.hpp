#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "config/import/imported_arm.hpp"

namespace truepose::config {

struct UrdfOptions {
  std::string
      base;  ///< link with the frame of the robot base; empty: `base` where there is one, else the root
  std::string
      tip;  ///< link with the frame of the flange; empty: `tool0` where there is one, else the only end
  std::map<std::string, std::string> arguments;  ///< of xacro:arg
  bool takes_masses = false;                     ///< many descriptions only make them up
};

/// The serial chain between two links of a URDF or xacro file, in modified DH. Lengths in m and angles in
/// rad, as URDF has them. Limits and speeds are rounded to 0.001 deg (mm). Throws ConfigError:
/// expand_xacro()'s; several ends; a joint that is neither fixed, revolute, continuous nor prismatic; one
/// that follows another (mimic).
ImportedArm load_urdf(const std::filesystem::path& file, const UrdfOptions& options);

}  // namespace truepose::config
