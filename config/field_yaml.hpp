#pragma once

#include <string>

#include "config/yaml_reader.hpp"
#include "core/identify/regression_field.hpp"

namespace truepose::config {

/// A residual field in a model file: the data it was fitted to and its hyper-parameters, every number with
/// the digits that bring it back exactly. `indent` stands before each line.
std::string field_text(const RegressionField& field, const std::string& indent);

/// Reads such a field of `robot`, whose joints say how many features it has. Throws ConfigError.
std::shared_ptr<const RegressionField> field_value(const YamlValue& value, const RobotModel& robot);

}  // namespace truepose::config
