#include "config/table/table_join.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <string_view>
#include <vector>

#include "config/number_text.hpp"
#include "core/data/measured_time.hpp"

namespace truepose::config {
namespace {

/// What a row is called, so far as two files agree on it.
std::string key_of(std::string_view text) {
  if (const auto colons = text.rfind("::"); colons != std::string_view::npos) text.remove_prefix(colons + 2);
  if (const auto time = measured_time(text); time && time->form != TimeForm::Number)
    return "at " + format_number(time->seconds);
  if (const auto number = parse_number(text)) return format_number(*number);
  std::string key{text};
  std::ranges::transform(key, key.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return key;
}

/// The number at the end of a name: "12" of "p12" and "P_012"; empty: there is none.
std::string number_at_end(const std::string& key) {
  const auto end = key.find_last_not_of("0123456789") + 1;
  if (end == 0 || end == key.size()) return {};
  return key.substr(std::min(key.find_first_not_of('0', end), key.size() - 1));
}

using Keys = std::vector<std::string>;

Keys keys_of(const CsvTable& table, std::size_t column) {
  Keys keys;
  for (std::size_t row = 0; row < table.row_count(); ++row) keys.push_back(key_of(table.text(row, column)));
  return keys;
}

Keys numbers_at_end(const Keys& keys) {
  Keys numbers;
  for (const std::string& key : keys) numbers.push_back(number_at_end(key));
  return numbers;
}

/// A row of the joints for each point; the number of rows: none.
using Matches = std::vector<std::size_t>;

Matches matches_of(const Keys& joints, const Keys& points) {
  std::map<std::string, std::size_t> row_of;
  for (std::size_t row = 0; row < joints.size(); ++row)
    if (!joints[row].empty() && !row_of.emplace(joints[row], row).second)
      return {};  // no key: it is there twice
  Matches matches;
  for (const std::string& key : points) {
    const auto found = row_of.find(key);
    matches.push_back(found == row_of.end() ? joints.size() : found->second);
  }
  return matches;
}

/// Two columns that may join the tables.
struct Join {
  std::string joints, points;  ///< what they are called
  Matches matches;
  std::size_t matched = 0;
};

bool is_key_column(const std::string& name) {
  return name.starts_with(kKeyPrefix) || name == "pose" || name == "point" || name == "time";
}

std::string shown_name(const std::string& column) {
  return in_quotes(column.starts_with(kKeyPrefix) ? column.substr(std::string_view{kKeyPrefix}.size())
                                                  : column);
}

void add_join(std::vector<Join>& joins, const TwoTables& tables, const std::string& joints,
              const std::string& points) {
  const Keys a = keys_of(tables.joints, tables.joints.column(joints)),
             b = keys_of(tables.points, tables.points.column(points));
  const std::size_t none = tables.joints.row_count();
  for (const auto& [of_joints, of_points] :
       {std::pair{a, b}, std::pair{a, numbers_at_end(b)}, std::pair{numbers_at_end(a), b}}) {
    Join join{joints, points, matches_of(of_joints, of_points)};
    join.matched = static_cast<std::size_t>(
        std::ranges::count_if(join.matches, [&](std::size_t row) { return row < none; }));
    if (join.matched > 0) joins.push_back(std::move(join));
  }
}

std::vector<Join> possible_joins(const TwoTables& tables) {
  std::vector<Join> joins;
  for (const std::string& joints : tables.joints.columns())
    for (const std::string& points : tables.points.columns())
      if (is_key_column(joints) && is_key_column(points)) add_join(joins, tables, joints, points);
  return joins;
}

Join join_of(const TwoTables& tables) {
  const std::vector<Join> joins = possible_joins(tables);
  const auto best = std::ranges::max_element(joins, {}, &Join::matched);
  if (best == joins.end() ||
      2 * best->matched < std::min(tables.joints.row_count(), tables.points.row_count()))
    throw ConfigError(
        tables.joints_name + "+" + tables.points_name +
        ": no column joins the two files: give both a column with the name, number or time of the "
        "pose, such as 'point', and in the joints each only once");
  for (const Join& other : joins) {
    if (other.matched == best->matched && other.matches != best->matches)
      throw ConfigError(tables.joints_name + "+" + tables.points_name + ": " + shown_name(best->joints) +
                        " with " + shown_name(best->points) + " and " + shown_name(other.joints) + " with " +
                        shown_name(other.points) + " join the rows differently: remove one of the columns");
  }
  return *best;
}

void add_row(std::string& text, const CsvTable& table, std::size_t row,
             const std::vector<std::size_t>& columns, bool is_first) {
  for (const std::size_t column : columns) {
    if (!is_first) text += ',';
    is_first = false;
    text += csv_field(std::string{table.text(row, column)});
  }
}

}  // namespace

std::pair<CsvTable, std::string> joined(const TwoTables& tables) {
  const Join join = join_of(tables);
  std::vector<std::size_t> of_joints, of_points;
  std::string text;
  for (const auto& [table, columns] :
       {std::pair{&tables.joints, &of_joints}, std::pair{&tables.points, &of_points}}) {
    for (const std::string& name : table->columns()) {
      const bool is_twice = table == &tables.joints && tables.points.has(name);
      if (name.starts_with(kKeyPrefix) || is_twice) continue;
      columns->push_back(table->column(name));
      text += (text.empty() ? "" : ",") + name;
    }
  }
  int line = tables.points.line(0) - 1;
  const int first_line = line;
  std::set<std::size_t> used;
  for (std::size_t row = 0; row < tables.points.row_count(); ++row) {
    if (join.matches[row] == tables.joints.row_count()) continue;
    for (; line < tables.points.line(row); ++line) text += '\n';
    add_row(text, tables.joints, join.matches[row], of_joints, true);
    add_row(text, tables.points, row, of_points, of_joints.empty());
    used.insert(join.matches[row]);
  }
  std::string how = "joints of " + tables.joints_name + " by " + shown_name(join.joints) + ", points of " +
                    tables.points_name + " by " + shown_name(join.points) + ": " +
                    std::to_string(join.matched) + " joined";
  const std::size_t no_point = tables.joints.row_count() - used.size(),
                    no_joints = tables.points.row_count() - join.matched;
  if (no_point > 0) how += ", " + std::to_string(no_point) + " of the joints have no point";
  if (no_joints > 0) how += ", " + std::to_string(no_joints) + " of the points have no joints";
  return {CsvTable::parse(text + '\n', tables.joints_name + "+" + tables.points_name, first_line), how};
}

}  // namespace truepose::config
