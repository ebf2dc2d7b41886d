#pragma once

#include <filesystem>

#include "config/model_file.hpp"
#include "config/robot_file.hpp"

namespace truepose::tools {

/// The files that say which arm a command is about.
struct ArmFiles {
  std::filesystem::path robot;
  std::filesystem::path model;  ///< empty = none given
};

/// Reads a model file and refuses one of another arm than `nominal`. Throws ConfigError.
config::ModelFile load_model_of(const RobotModel& nominal, const std::filesystem::path& file);

}  // namespace truepose::tools
