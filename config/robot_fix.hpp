#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// Where a robot file says something, as errors say it: "arm.yaml:7:45: joints[3].sign". Where it does not
/// say it, what it would stand in.
///
/// @param joint  from 0; -1: `key` is one of the file's own, or of every joint: then that of the first
std::string robot_place(const std::filesystem::path& file, int joint, std::string_view key);

/// The text of a robot file with the geometry of `fixed`. Only numbers that differ are written; all else is
/// unchanged.
///
/// @param fixed  of as many joints
/// Throws ConfigError where the file cannot be read, or says things so (by aliases) that changing numbers in
/// place does not give `fixed`.
std::string fixed_robot_text(const std::filesystem::path& file, const RobotModel& fixed);

}  // namespace truepose::config
