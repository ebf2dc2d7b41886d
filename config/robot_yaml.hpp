#pragma once

#include <string>

#include "config/yaml_reader.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// A calibrated arm in a model file, two blanks indented: geometry, masses, deviations of the joints and
/// residual field (mm, rad, kg; every number with the digits that bring it back exactly). Joints count
/// from 1.
std::string robot_text(const RobotModel& robot);

/// Reads such an arm; what goes beyond geometry may be absent. Throws ConfigError.
RobotModel robot_value(const YamlValue& value);

}  // namespace truepose::config
