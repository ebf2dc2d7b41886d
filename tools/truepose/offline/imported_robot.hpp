#pragma once

#include <filesystem>
#include <string>

#include "config/import/imported_arm.hpp"

namespace truepose::tools {

/// Whether an arm comes from a KUKA controller: its archive (a folder or .zip), or $machine.dat.
bool has_machine_data(const std::filesystem::path& source);

/// The robot file of an arm, whose comment names its source.
std::string imported_robot_text(const config::ImportedArm& arm, const std::filesystem::path& source);

}  // namespace truepose::tools
