#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/csv_reader.hpp"
#include "core/arm/joint_units.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose::config {

/// A joint position as a file writes it. It reads back as exactly `q` where `q` came from such a text.
std::string joint_field(double q, const Joint& joint);

/// "q1".."qN" for the prefix "q".
std::vector<std::string> joint_column_names(std::string_view prefix, const RobotModel& robot);

/// The columns q1..qN of a table. Throws ConfigError where one is missing.
class JointColumns {
 public:
  JointColumns(const CsvTable& table, const RobotModel& robot);
  JointVector at(std::size_t row) const;

 private:
  const CsvTable& table_;
  const RobotModel& robot_;
  std::vector<std::size_t> columns_;
};

}  // namespace truepose::config
