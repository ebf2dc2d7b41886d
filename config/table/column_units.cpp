#include "config/table/column_units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "config/number_text.hpp"
#include "core/data/other_units.hpp"
#include "core/formatted.hpp"
#include "core/math/units.hpp"

namespace truepose::config {
namespace {

bool is_angle(const TableForm& form, std::string_view name) {
  if (name.size() > 1 && name[0] == 'q') {
    const std::size_t joint = static_cast<std::size_t>(std::stoi(std::string{name.substr(1)})) - 1;
    return !form.robot || form.robot->joints.at(joint).type == JointType::Revolute;
  }
  constexpr std::array<std::string_view, 7> kAngles{"a", "b", "c", "ca", "cb", "cc", "sigma_abc"};
  return std::ranges::find(kAngles, name) != kAngles.end();
}

bool is_length(const TableForm& form, std::string_view name) {
  if (name.size() > 1 && name[0] == 'q') return !is_angle(form, name);
  constexpr std::array<std::string_view, 14> kLengths{"x",      "y",         "z",         "px",       "py",
                                                      "pz",     "cx",        "cy",        "cz",       "sigma",
                                                      "excess", "payload_x", "payload_y", "payload_z"};
  return std::ranges::find(kLengths, name) != kLengths.end();
}

/// Whether --units are its units: of standard deviations they are not.
bool takes_stated_units(std::string_view name) {
  return name != "sigma" && name != "sigma_abc" && name != "excess";
}

/// A unit that is converted to deg or mm.
struct ReadUnit {
  std::string_view name;
  bool of_angles;
  double factor;
};
constexpr std::array kReadUnits{ReadUnit{"deg", true, 1},    ReadUnit{"rad", true, kDegPerRad},
                                ReadUnit{"gon", true, 0.9},  ReadUnit{"mm", false, 1},
                                ReadUnit{"cm", false, 10},   ReadUnit{"m", false, kMmPerMetre},
                                ReadUnit{"um", false, 1e-3}, ReadUnit{"inch", false, kMmPerInch}};

/// Refuses joints or coordinates of which some say another unit than deg and mm, and some say none.
void expect_units_of(const ForeignTable& table, bool (*is_of_kind)(const std::string& name)) {
  std::optional<std::size_t> stated, silent;
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    const auto& [name, unit] = table.columns[k];
    if (!is_of_kind(name)) continue;
    if (unit.empty()) silent = silent.value_or(k);
    if (!unit.empty() && unit != "deg" && unit != "mm") stated = stated.value_or(k);
  }
  if (stated && silent)
    table.fail("column " + in_quotes(table.headers[*stated]) + " is in " + table.columns[*stated].unit +
               ", and " + in_quotes(table.headers[*silent]) + " says no unit: name the unit of all");
}

bool is_joint_column(const std::string& name) {
  return name.size() > 1 && name[0] == 'q' && name[1] >= '0' && name[1] <= '9';
}
bool is_coordinate(const std::string& name) { return name == "x" || name == "y" || name == "z"; }

}  // namespace

double factor_of(const ForeignTable& table, std::size_t column, const TableForm& form,
                 const TableReading& reading) {
  const ColumnName& meaning = table.columns[column];
  const bool angle = is_angle(form, meaning.name), length = is_length(form, meaning.name);
  std::string unit = meaning.unit;
  if (reading.units && (angle || length) && takes_stated_units(meaning.name)) {
    const std::string& stated = angle ? reading.units->angle : reading.units->length;
    if (!unit.empty() && unit != stated)
      table.fail("column " + in_quotes(table.headers[column]) + " says " + unit + ", and --units says " +
                 stated);
    unit = stated;
  }
  if (unit.empty()) return 1;
  const std::string is_in = "column " + in_quotes(table.headers[column]) + " is in " + unit;
  const auto* const read = std::ranges::find(kReadUnits, unit, &ReadUnit::name);
  if (read == kReadUnits.end())
    table.fail(is_in + ", which is not read. Convert it to deg, rad, gon, mm, cm, m, um or inch");
  if (unit == "deg" || unit == "mm" ? (read->of_angles ? length : angle)
                                    : !(read->of_angles ? angle : length))
    table.fail(is_in + ", and " + meaning.name +
               (angle    ? " is an angle"
                : length ? " is a length"
                         : " has no such unit"));
  return read->factor;
}

double converted(double value, const ForeignTable& table, std::size_t row, std::size_t column,
                 const TableForm& form) {
  constexpr double kLargestTurn_deg = 3600, kFarthestPoint_mm = 1e5;
  const bool angle = is_angle(form, table.columns[column].name);
  const double greatest = angle ? kLargestTurn_deg : kFarthestPoint_mm;
  if (std::abs(value) > greatest)
    table.fail(row, column,
               in_quotes(table.rows[row].fields[column]) +
                   formatted(" would be %.0f %s, beyond any arm (%.0f). Correct the unit of this column",
                             value, angle ? "deg" : "mm", greatest));
  return value;
}

void expect_units_of_all(const ForeignTable& table) {
  expect_units_of(table, is_joint_column);
  expect_units_of(table, is_coordinate);
}

}  // namespace truepose::config
