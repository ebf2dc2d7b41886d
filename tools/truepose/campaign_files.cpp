#include "tools/truepose/campaign_files.hpp"

#include <vector>

#include "config/csv_reader.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

/// "q1" for the first joint.
std::string joint_column(std::size_t number) {
  std::string name{"q"};
  return name += std::to_string(number);
}

/// The joints' columns, as many as the file has.
std::vector<std::string> joint_columns_of(const config::CsvTable& table) {
  std::vector<std::string> names;
  while (table.has(joint_column(names.size() + 1))) names.push_back(joint_column(names.size() + 1));
  return names;
}

}  // namespace

json::object targets_of_file(const std::filesystem::path& file) {
  const config::CsvTable table = config::CsvTable::read(file);
  std::vector<std::string> names = joint_columns_of(table);
  const bool are_joints = !names.empty();
  if (!are_joints) names = {"x", "y", "z", "a", "b", "c"};
  std::vector<std::string> known = names;
  if (are_joints) known.insert(known.end(), {"residual_mm", "residual_deg", "sigma_mm"});
  table.expect_only(known);
  std::vector<std::size_t> columns;
  for (const std::string& name : names) columns.push_back(table.column(name));
  json::array rows;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    json::array values;
    for (const std::size_t column : columns) values.emplace_back(table.number(row, column));
    rows.push_back(std::move(values));
  }
  return {{are_joints ? "joints" : "poses", std::move(rows)}};
}

std::string joints_csv(const json::value& targets) {
  std::string header, rows;
  for (const json::value& target : targets.at("targets").as_array()) {
    const json::array& joints = target.at("joints_deg").as_array();
    if (joints.empty()) continue;
    header.clear();
    for (std::size_t i = 0; i < joints.size(); ++i) {
      header += joint_column(i + 1) + ",";
      rows += control::json_text(joints[i]) + ",";
    }
    rows += control::json_text(target.at("errors_mm").as_array().back()) + "\n";
  }
  return header + "residual_mm\n" + rows;
}

std::string cycles_csv(const json::value& iso9283, const std::string& started, const json::array& points) {
  const json::array& commanded = iso9283.at("commanded").as_array();
  std::string csv = "time,point,cycle,direction,x,y,z,cx,cy,cz\n";
  for (const json::value& point : points) {
    const auto pose = point.at("pose").to_number<std::size_t>();
    const json::value& asked = commanded[pose % commanded.size()];
    csv += started;
    (csv += ',') += asked.at("point").as_string();
    (csv += ',') += std::to_string(pose / commanded.size() + 1);
    csv += ',';
    if (const json::value* direction = asked.as_object().if_contains("direction"))
      csv += direction->as_string();
    for (const json::value& coordinate : point.at("p_mm").as_array())
      (csv += ',') += control::json_text(coordinate);
    for (const char* axis : {"x", "y", "z"}) (csv += ',') += control::json_text(asked.at(axis));
    csv += '\n';
  }
  return csv;
}

}  // namespace truepose::tools
