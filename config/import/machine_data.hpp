#pragma once

#include <filesystem>
#include <string>

#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// The arm that a KUKA controller's machine data describe: lengths, software limits and axis speeds, in the
/// rows of the shipped KR 210. Refuses arms other than the six axis ones with a central wrist and axes that
/// count as on these.
///
/// @param text   R1/Mada/$machine.dat
/// @param place  begins the messages
/// Throws ConfigError.
RobotModel robot_of_machine_data(const std::string& text, const std::string& place);

/// The same of a controller's archive (folder or .zip) or of the file itself. Throws ConfigError.
RobotModel load_machine_data(const std::filesystem::path& source);

}  // namespace truepose::config
