#pragma once

#include <filesystem>
#include <vector>

#include "config/yaml_reader.hpp"
#include "core/arm/robot_model.hpp"
#include "core/plan/scene.hpp"

namespace truepose::config {

/// Reads a robot file (YAML; mm, deg, deg/s, kg). A payload becomes part of the last link's mass. Throws
/// ConfigError naming file, line, column and key.
RobotModel load_robot(const std::filesystem::path& file);

/// Adds {kg, x, y, z}, its centre in mm in the flange frame, to the mass of the last link. An error where the
/// arm's own masses are not known.
void add_payload(RobotModel& robot, const YamlValue& value);

/// What the arm of a robot file occupies, link by link; empty where the file does not say.
std::vector<BodyPart> load_body(const std::filesystem::path& file);

}  // namespace truepose::config
