#pragma once

#include <vector>

#include "config/yaml_reader.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// The joints of an arm, 1 to kMaxJoints of them, each read by `joint`.
std::vector<Joint> joints_value(const YamlValue& joints, Joint (*joint)(const YamlValue&));

}  // namespace truepose::config
