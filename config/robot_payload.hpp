#pragma once

#include "config/yaml_reader.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// Adds {kg, x, y, z}, its centre in mm in the flange frame, to the mass of the last link. An error where the
/// arm's own masses are not known.
void add_payload(RobotModel& robot, const YamlValue& value);

}  // namespace truepose::config
