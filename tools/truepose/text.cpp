#include "tools/truepose/text.hpp"

#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/value.hpp>

#include "core/formatted.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::tools {

namespace json = boost::json;

std::string text_table(const std::vector<Column>& columns, const std::vector<Cells>& rows) {
  std::string out;
  for (const Cells& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const auto [width, gap] = columns[i];
      const auto least = static_cast<std::size_t>(std::abs(width));
      const std::string filling(least - std::min(least, row[i].size()), ' ');
      line.append(static_cast<std::size_t>(gap), ' ');
      line += width < 0 ? row[i] + filling : filling + row[i];
    }
    out += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
  }
  return out;
}

std::string text_table(const std::vector<Cells>& rows) {
  std::vector<Column> columns;
  for (const Cells& row : rows) {
    while (columns.size() < row.size()) columns.push_back({.width = 0, .gap = columns.empty() ? 0 : 2});
    for (std::size_t i = 0; i < row.size(); ++i)
      columns[i].width = std::min(columns[i].width, -static_cast<int>(row[i].size()));
  }
  return text_table(columns, rows);
}

std::string shown(const std::string& text) { return text.empty() ? "-" : text; }

std::string shown(std::optional<double> number, int decimals, const char* unit) {
  return number ? formatted("%.*f%s", decimals, *number, unit) : "-";
}

const json::value* find_at(const json::value& value, std::string_view pointer) {
  boost::system::error_code missing;
  const json::value* found = value.find_pointer({pointer.data(), pointer.size()}, missing);
  return missing || found->is_null() ? nullptr : found;
}

std::string text_at(const json::value& value, std::string_view pointer) {
  const json::value* found = find_at(value, pointer);
  if (!found) return "-";
  if (found->is_string()) return found->get_string().empty() ? "-" : std::string{found->get_string()};
  if (found->is_bool()) return found->get_bool() ? "yes" : "no";
  return control::json_text(*found);
}

std::string number_at(const json::value& value, std::string_view pointer, int decimals, const char* unit) {
  const json::value* found = find_at(value, pointer);
  if (!found || !found->is_number()) return "-";
  return formatted("%.*f%s", decimals, found->to_number<double>(), unit);
}

std::string string_at(const json::value& value, std::string_view pointer) {
  const json::value* found = find_at(value, pointer);
  return found && found->is_string() ? std::string{found->get_string()} : "";
}

bool is_true_at(const json::value& value, std::string_view pointer) {
  const json::value* found = find_at(value, pointer);
  return found && found->is_bool() && found->get_bool();
}

const json::array& list_at(const json::value& value, std::string_view pointer) {
  static const json::array kNone;
  const json::value* found = find_at(value, pointer);
  return found && found->is_array() ? found->get_array() : kNone;
}

}  // namespace truepose::tools
