#include "config/table/foreign_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "config/number_text.hpp"
#include "config/table/table_records.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/math/units.hpp"

namespace truepose::config {
namespace {

using KrlMembers = std::vector<std::pair<std::string, std::string>>;

/// Names and values of "{E6AXIS: A1 1.0, A2 2.0}", whose blanks and commas are kKrlBlank; none for another
/// text.
KrlMembers krl_members(std::string_view field) {
  if (!field.starts_with('{') || !field.ends_with('}')) return {};
  field = field.substr(1, field.size() - 2);
  if (const auto colon = field.find(':'); colon != std::string_view::npos) field.remove_prefix(colon + 1);
  std::vector<std::string> words;
  while (!field.empty()) {
    const auto end = std::min(field.find(kKrlBlank), field.size());
    if (end > 0) words.emplace_back(field.substr(0, end));
    field.remove_prefix(std::min(end + 1, field.size()));
  }
  KrlMembers members;
  if (words.size() % 2 != 0) return {};
  for (std::size_t k = 0; k < words.size(); k += 2) members.emplace_back(words[k], words[k + 1]);
  return members;
}

void expand_krl_column(ForeignTable& table, std::size_t column) {
  const KrlMembers first = krl_members(table.rows.front().fields[column]);
  if (first.empty()) return;
  std::vector<std::vector<std::string>> values(first.size());
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const KrlMembers members = krl_members(table.rows[row].fields[column]);
    if (!std::ranges::equal(members, first, {}, &KrlMembers::value_type::first,
                            &KrlMembers::value_type::first))
      table.fail(row, column, "expected an aggregate of the same members as in row 1");
    for (std::size_t k = 0; k < members.size(); ++k) values[k].push_back(members[k].second);
  }
  table.columns[column] = {};
  for (std::size_t k = 0; k < first.size(); ++k)
    table.add(table.headers[column] + "." + first[k].first, column_name(first[k].first), values[k]);
}

/// The numbers of columns in one row.
template <std::size_t N>
std::array<double, N> numbers_at(const ForeignTable& table, std::size_t row,
                                 const std::array<std::size_t, N>& columns) {
  std::array<double, N> numbers{};
  for (std::size_t k = 0; k < N; ++k) {
    const auto number = parse_number(table.rows[row].fields[columns[k]]);
    if (!number) table.fail(row, columns[k], number.error());
    numbers[k] = *number;
  }
  return numbers;
}

template <std::size_t N>
std::optional<std::array<std::size_t, N>> places_of(const ForeignTable& table,
                                                    const std::array<const char*, N>& names) {
  std::array<std::size_t, N> places{};
  for (std::size_t k = 0; k < N; ++k) {
    places[k] = table.find(names[k]);
    if (places[k] == table.headers.size()) return std::nullopt;
  }
  return places;
}

Eigen::Matrix3d rotation_of(const ForeignTable& table, std::size_t row,
                            const std::array<std::size_t, 4>& columns) {
  constexpr double kMostOff = 0.01;  // of the length: a quaternion of two decimals
  const auto [w, x, y, z] = numbers_at(table, row, columns);
  const Eigen::Quaterniond q{w, x, y, z};
  if (std::abs(q.norm() - 1) > kMostOff)
    table.fail(row, columns[0], formatted("the quaternion has the length %.4g, expected 1", q.norm()));
  return q.normalized().toRotationMatrix();
}

/// What one of the angle's unit is in rad.
double unit_of_angles(const ForeignTable& table, const std::array<std::size_t, 3>& columns,
                      std::string_view stated) {
  double most = 0;
  for (std::size_t row = 0; row < table.rows.size(); ++row)
    for (const double angle : numbers_at(table, row, columns)) most = std::max(most, std::abs(angle));
  const std::string& own = table.columns[columns[0]].unit;
  const std::string_view unit = own.empty() ? stated : std::string_view{own};
  if (unit == "rad") return 1;
  if (unit.empty() && most <= 2 * std::numbers::pi)
    table.fail(table.headers[columns[0]] + ", " + table.headers[columns[1]] + ", " +
               table.headers[columns[2]] + ": no angle is beyond " + formatted("%.3g", most) +
               ": they may be deg or rad. Say which: --units deg,mm or --units rad,mm");
  return kRadPerDeg;
}

/// The column "a", "b", "c" of orientations.
void add_angles(ForeignTable& table, const std::vector<Eigen::Matrix3d>& R) {
  std::array<std::vector<std::string>, 3> angles;
  for (const Eigen::Matrix3d& each : R) {
    const Eigen::Vector3d abc_deg = kuka_abc_deg(each);
    for (std::size_t k = 0; k < 3; ++k)
      angles[k].push_back(format_number(abc_deg[static_cast<Eigen::Index>(k)]));
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string name(1, "abc"[k]);
    table.add(name, {name, "deg"}, angles[k]);
  }
}

/// Takes the units from the numbers of a column.
void take_units(ForeignTable& table, std::size_t column) {
  ColumnName& meaning = table.columns[column];
  std::string found;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    auto [number, unit] = without_unit(table.rows[row].fields[column]);
    if (unit.empty() && found.empty()) continue;
    if (row == 0) found = meaning.unit.empty() ? unit : meaning.unit;
    if (unit != found)
      table.fail(row, column,
                 "is in " + (unit.empty() ? "no unit" : unit) + ", where others are in " +
                     (found.empty() ? "none" : found) + ": write all in one unit");
    table.rows[row].fields[column] = std::move(number);
  }
  if (!found.empty()) meaning.unit = found;
}

/// Counts of the numbers of a table by their marks.
struct Marks {
  int commas = 0, sure_commas = 0;
  std::optional<std::pair<std::size_t, std::size_t>> point, comma;  ///< row and column of the first of each
};

void count_marks(const ForeignTable& table, std::size_t column, Marks& marks) {
  constexpr double kGreatestJoint = 720;  // a joint beyond has no thousands in it
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const std::string& field = table.rows[row].fields[column];
    const auto number = number_marks(field);
    if (!number) continue;
    if (number->has_groups)
      table.fail(row, column, in_quotes(field) + " has its thousands set apart: export numbers without that");
    if (number->points > 0 && !marks.point) marks.point = {row, column};
    if (number->commas == 0) continue;
    if (!marks.comma) marks.comma = {row, column};
    ++marks.commas;
    const bool is_joint = table.columns[column].name.starts_with('q');
    const auto whole = parse_number(std::string_view{field}.substr(0, field.find(',')));
    const bool too_great = is_joint && whole && std::abs(*whole) * 1000 > kGreatestJoint;
    if (!number->may_be_group || too_great) ++marks.sure_commas;
  }
}

/// Refuses points such as "1.500", where others are "200": all that have a point may have thousands set
/// apart.
void refuse_grouped_points(const ForeignTable& table) {
  std::optional<std::pair<std::size_t, std::size_t>> group;
  bool has_whole = false;
  for (const char* name : {"x", "y", "z"}) {
    const std::size_t column = table.find(name);
    if (column == table.columns.size()) continue;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      const auto number = number_marks(table.rows[row].fields[column]);
      if (!number) continue;
      has_whole |= number->points == 0;
      if (number->points > 0 && !number->may_be_group) return;
      if (number->points > 0 && !group) group = {row, column};
    }
  }
  if (!group || !has_whole) return;
  const std::string& field = table.rows[group->first].fields[group->second];
  std::string none = field;
  none.erase(none.find('.'), 1);
  table.fail(group->first, group->second,
             in_quotes(field) + " may be " + field + " or " + none +
                 ", as other coordinates have no point: save the file without thousands separators");
}

}  // namespace

void ForeignTable::fail(std::size_t row, std::size_t column, std::string_view what) const {
  throw ConfigError(file + ": row " + std::to_string(row + 1) + " (line " + std::to_string(rows[row].line) +
                    "): " + headers[column] + ": " + std::string(what));
}

void ForeignTable::fail(std::string_view what) const { throw ConfigError(file + ": " + std::string(what)); }

std::size_t ForeignTable::find(std::string_view name) const {
  return static_cast<std::size_t>(std::ranges::find(columns, name, &ColumnName::name) - columns.begin());
}

void ForeignTable::add(std::string header, ColumnName meaning, const std::vector<std::string>& fields) {
  headers.push_back(std::move(header));
  columns.push_back(std::move(meaning));
  for (std::size_t row = 0; row < rows.size(); ++row) rows[row].fields.push_back(fields[row]);
}

std::string leave_out_invalid_rows(ForeignTable& table) {
  const auto column =
      static_cast<std::size_t>(std::ranges::find_if(table.headers, names_validity) - table.headers.begin());
  if (column == table.headers.size()) return {};
  const auto invalid =
      std::erase_if(table.rows, [&](const CsvRow& row) { return says_invalid(row.fields[column]); });
  if (invalid == 0) return {};
  if (table.rows.empty())
    table.fail(in_quotes(table.headers[column]) + " says of each row that it is not valid");
  return std::to_string(invalid) + (invalid == 1 ? " row" : " rows") + " left out, not valid by " +
         in_quotes(table.headers[column]);
}

void expand_krl_columns(ForeignTable& table) {
  if (table.rows.empty()) return;
  const std::size_t count = table.headers.size();
  for (std::size_t column = 0; column < count; ++column) expand_krl_column(table, column);
}

std::string convert_orientations(ForeignTable& table, std::string_view angle_unit) {
  if (table.find("a") != table.headers.size()) return {};
  std::vector<Eigen::Matrix3d> R;
  if (const auto quaternion = places_of<4>(table, {"qw", "qx", "qy", "qz"})) {
    for (std::size_t row = 0; row < table.rows.size(); ++row)
      R.push_back(rotation_of(table, row, *quaternion));
    add_angles(table, R);
    return "a, b, c from the quaternion";
  }
  if (places_of<3>(table, {"rx", "ry", "rz"})) {
    table.fail(
        "columns rx, ry, rz may be a rotation vector (rad, Universal Robots) or angles about x, y, z (deg): "
        "give the orientation as a, b, c, as roll, pitch, yaw or as qw, qx, qy, qz");
  }
  auto angles = places_of<3>(table, {"roll", "pitch", "yaw"});
  if (!angles) angles = places_of<3>(table, {"w", "p", "r"});  // of FANUC, about the same axes
  if (angles) {
    const double unit = unit_of_angles(table, *angles, angle_unit);
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      const auto [roll, pitch, yaw] = numbers_at(table, row, *angles);
      R.push_back(rotation_zyx(yaw * unit, pitch * unit, roll * unit));
    }
    add_angles(table, R);
    return "a, b, c from angles about the fixed x, y, z";
  }
  return {};
}

bool normalise_numbers(ForeignTable& table) {
  Marks marks;
  for (std::size_t column = 0; column < table.headers.size(); ++column) {
    if (table.columns[column].name.empty() || holds_words(table.columns[column].name)) continue;
    take_units(table, column);
    count_marks(table, column, marks);
  }
  if (marks.commas == 0) {
    refuse_grouped_points(table);
    return false;
  }
  const auto [row, column] = *marks.comma;
  if (marks.point) {
    const auto& [r, c] = *marks.point;
    table.fail(
        r, c,
        in_quotes(table.rows[r].fields[c]) + " has a point where other numbers have a decimal comma (" +
            in_quotes(table.rows[row].fields[column]) + "): export numbers without thousands separators");
  }
  if (marks.sure_commas == 0) {
    std::string point = table.rows[row].fields[column], none = point;
    point.replace(point.find(','), 1, ".");
    none.erase(none.find(','), 1);
    table.fail(row, column,
               in_quotes(table.rows[row].fields[column]) + " may be " + point + " or " + none +
                   ": save the file with decimal points, without thousands separators");
  }
  for (std::size_t k = 0; k < table.headers.size(); ++k) {
    if (table.columns[k].name.empty() || holds_words(table.columns[k].name)) continue;
    for (CsvRow& each : table.rows)
      if (number_marks(each.fields[k])) std::ranges::replace(each.fields[k], ',', '.');
  }
  return true;
}

}  // namespace truepose::config
