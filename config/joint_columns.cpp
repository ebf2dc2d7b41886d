#include "config/joint_columns.hpp"

#include <cmath>
#include <limits>

#include "config/number_text.hpp"

namespace truepose::config {

std::string joint_field(double q, const Joint& joint) {
  const double value = q / unit_of(joint);
  // The division rounds, so the value that was multiplied may be a neighbour.
  for (const double toward :
       {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}) {
    const double neighbour = std::nextafter(value, toward);
    if (value * unit_of(joint) != q && neighbour * unit_of(joint) == q) return format_number(neighbour);
  }
  return format_number(value);
}

std::vector<std::string> joint_column_names(std::string_view prefix, const RobotModel& robot) {
  std::vector<std::string> names;
  for (int i = 1; i <= robot.joint_count(); ++i) names.push_back(std::string(prefix) + std::to_string(i));
  return names;
}

JointColumns::JointColumns(const CsvTable& table, const RobotModel& robot) : table_(table), robot_(robot) {
  for (const std::string& name : joint_column_names("q", robot)) columns_.push_back(table.column(name));
}

JointVector JointColumns::at(std::size_t row) const {
  JointVector q(robot_.joint_count());
  for (int i = 0; i < robot_.joint_count(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    q[i] = table_.number(row, columns_[index]) * unit_of(robot_.joints[index]);
  }
  return q;
}

}  // namespace truepose::config
