#pragma once

#include <filesystem>
#include <vector>

#include "config/yaml_reader.hpp"
#include "core/arm/robot_model.hpp"
#include "core/plan/scene.hpp"

namespace truepose::config {

/// Reads a robot file (YAML; mm, deg, deg/s, kg), or a shipped one by its name (robot_file_of()). Throws
/// ConfigError naming file, line, column and key.
RobotModel load_robot(const std::filesystem::path& file);
/// The same of a text; `file_name` stands in the messages.
RobotModel parse_robot(const std::string& text, const std::string& file_name);

/// Lets the arm carry {kg, x, y, z}, its centre in mm in the flange frame. An error where the arm's own
/// masses are not known.
void add_payload(RobotModel& robot, const YamlValue& value);

/// What the arm of a robot file occupies, link by link; empty where the file does not say.
std::vector<BodyPart> load_body(const std::filesystem::path& file);

}  // namespace truepose::config
