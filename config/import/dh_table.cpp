#include "config/import/dh_table.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <vector>

#include "config/number_text.hpp"
#include "config/table/csv_reader.hpp"
#include "config/table/foreign_table.hpp"
#include "config/table/table_records.hpp"
#include "config/table/text_encoding.hpp"
#include "core/arm/forward.hpp"
#include "core/arm/joint_units.hpp"
#include "core/math/angles.hpp"

namespace truepose::config {
namespace {

enum class Quantity { Length, Angle, OfJoint, Plain };

struct DhColumn {
  std::string_view name, other_name;
  Quantity quantity;
  bool required = false;
};

constexpr std::array kColumns{
    DhColumn{"joint", "name", Quantity::Plain},         DhColumn{"a", "r", Quantity::Length, true},
    DhColumn{"alpha", "", Quantity::Angle, true},       DhColumn{"d", "", Quantity::Length, true},
    DhColumn{"theta", "offset", Quantity::Angle, true}, DhColumn{"beta", "", Quantity::Angle},
    DhColumn{"sign", "sense", Quantity::Plain},         DhColumn{"type", "", Quantity::Plain},
    DhColumn{"min", "lower", Quantity::OfJoint},        DhColumn{"max", "upper", Quantity::OfJoint},
    DhColumn{"speed", "velocity", Quantity::OfJoint},   DhColumn{"acceleration", "", Quantity::OfJoint}};

struct Unit {
  std::string_view name;
  Quantity quantity;
  double factor;
};
constexpr std::array kUnits{Unit{"mm", Quantity::Length, 1}, Unit{"cm", Quantity::Length, 10},
                            Unit{"m", Quantity::Length, 1000}, Unit{"deg", Quantity::Angle, kRadPerDeg},
                            Unit{"rad", Quantity::Angle, 1}};

/// "alpha [deg]" is alpha and deg.
std::pair<std::string, std::string> name_and_unit(std::string_view header) {
  std::string name, unit;
  std::string* part = &name;
  for (const char c : header) {
    if (c == '(' || c == '[' || c == '_') {
      part = &unit;
    } else if (c != ')' && c != ']' && c != ' ') {
      *part += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return {name, unit};
}

const Unit* unit_named(std::string_view name) {
  const auto* unit = std::ranges::find(kUnits, name, &Unit::name);
  return unit == kUnits.end() ? nullptr : unit;
}

/// The text of a table with commas and decimal points, whatever it has; the unit of its cells in the name.
std::string own_text(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::vector<CsvRow> rows =
      table_records(decode_text(read_bytes(file, CsvTable::kMostBytes), name).text, name).rows;
  std::erase_if(rows, is_comment);
  if (rows.empty()) return {};
  ForeignTable table{.file = name, .headers = rows[0].fields, .columns = {}, .rows = {}};
  for (const std::string& header : table.headers) table.columns.push_back({header, {}});
  table.rows.assign(rows.begin() + 1, rows.end());
  const auto is_full = [&](const CsvRow& row) { return row.fields.size() == table.headers.size(); };
  if (std::ranges::all_of(table.rows, is_full)) normalise_numbers(table);
  for (std::size_t k = 0; k < table.headers.size(); ++k)
    if (const std::string& unit = table.columns[k].unit; !unit.empty()) table.headers[k] += " (" + unit + ")";
  table.rows.insert(table.rows.begin(), {table.headers, rows[0].line});
  std::string text;
  int line = 1;
  for (const CsvRow& row : table.rows) {
    for (; line < row.line; ++line) text += '\n';
    for (const std::string& field : row.fields)
      text += (&field == &row.fields.front() ? "" : ",") + csv_field(field);
  }
  return text + '\n';
}

/// A table with its columns recognised.
class DhRows {
 public:
  DhRows(const std::filesystem::path& file, const std::optional<DhUnits>& units)
      : text_{own_text(file)}, table_{CsvTable::parse(text_, file.string())} {
    CsvScanner scanner{text_, file_name_ = file.string()};
    const std::vector<std::string> headers = scanner.next().value().fields;
    for (std::size_t i = 0; i < headers.size(); ++i) recognise(headers[i], i, units);
    for (const DhColumn& column : kColumns)
      if (column.required && !find(column.name))
        table_.fail("missing column '" + std::string{column.name} + "'");
  }

  std::size_t size() const { return table_.row_count(); }
  bool has(std::string_view name) const { return find(name) != nullptr; }
  std::string_view text(std::size_t row, std::string_view name) const {
    return table_.text(row, find(name)->index);
  }
  /// In mm and rad.
  double number(std::size_t row, std::string_view name, bool is_length) const {
    const Column& column = *find(name);
    return table_.number(row, column.index) * (is_length ? column.mm : column.rad);
  }
  [[noreturn]] void fail(std::size_t row, std::string_view name, std::string_view what) const {
    table_.fail(row, find(name)->index, what);
  }

 private:
  struct Column {
    std::string_view name;
    std::size_t index = 0;
    double mm = 1, rad = 1;
  };

  void recognise(const std::string& header, std::size_t index, const std::optional<DhUnits>& units) {
    constexpr std::array<std::string_view, 5> kJointNames{"i", "link", "no", "nr", "axis"};
    auto [name, unit] = name_and_unit(header);
    if (std::ranges::find(kJointNames, name) != kJointNames.end()) name = "joint";
    const auto* column = std::ranges::find_if(kColumns, [&](const DhColumn& each) {
      return each.name == name || (!name.empty() && each.other_name == name);
    });
    if (column == kColumns.end())
      table_.fail(
          "unknown column " + in_quotes(header) +
          ", expected a, alpha, d, theta and perhaps joint, beta, sign, type, min, max, speed, acceleration");
    if (find(column->name)) table_.fail("the column " + std::string{column->name} + " is there twice");
    Column found{column->name, index};
    if (column->quantity == Quantity::Plain) return columns_.push_back(found);
    if (!unit.empty()) {
      take_unit(header, unit, *column, found);
    } else if (units) {
      found.mm = units->mm;
      found.rad = units->rad;
    } else {
      table_.fail(
          "column " + in_quotes(header) +
          ": no unit is said. Write it into the name, as in a (mm) and alpha (deg), or give --units mm,deg.");
    }
    columns_.push_back(found);
  }
  /// "mm", "deg/s", or of a column that is by its joint's type "deg|mm".
  void take_unit(const std::string& header, std::string_view unit, const DhColumn& column,
                 Column& found) const {
    while (!unit.empty()) {
      const std::size_t bar = std::min(unit.find('|'), unit.size());
      const Unit* named = unit_named(unit.substr(0, std::min(bar, unit.find('/'))));
      if (!named || (column.quantity != Quantity::OfJoint && named->quantity != column.quantity))
        table_.fail("column " + in_quotes(header) +
                    ": this unit is not known here. Write a (mm), alpha (deg), d (mm), theta (deg)");
      (named->quantity == Quantity::Length ? found.mm : found.rad) = named->factor;
      unit.remove_prefix(std::min(bar + 1, unit.size()));
    }
  }
  const Column* find(std::string_view name) const {
    const auto found = std::ranges::find(columns_, name, &Column::name);
    return found == columns_.end() ? nullptr : &*found;
  }

  std::string text_, file_name_;
  CsvTable table_;
  std::vector<Column> columns_;
};

bool is_flange(const DhRows& rows, std::size_t row) {
  return rows.has("joint") && rows.text(row, "joint") == "flange";
}

Joint joint_of(const DhRows& rows, std::size_t row) {
  Joint joint;
  joint.a_mm = rows.number(row, "a", true);
  joint.alpha_rad = rows.number(row, "alpha", false);
  joint.d_mm = rows.number(row, "d", true);
  if (const std::string_view theta = rows.text(row, "theta");
      theta.starts_with('q') || theta.starts_with("theta") || theta.starts_with("\xCE\xB8"))
    rows.fail(row, "theta", in_quotes(theta) + " names the joint's angle. Write its offset, 0 for none");
  joint.theta_rad = rows.number(row, "theta", false);
  if (rows.has("beta")) joint.beta_rad = rows.number(row, "beta", false);
  if (rows.has("sign")) {
    joint.sign = rows.number(row, "sign", true);
    if (std::abs(joint.sign) != 1) rows.fail(row, "sign", "expected 1 or -1");
  }
  if (rows.has("type")) {
    const std::string_view type = rows.text(row, "type");
    if (type != "revolute" && type != "prismatic") rows.fail(row, "type", "expected revolute or prismatic");
    if (type == "prismatic") joint.type = JointType::Prismatic;
  }
  return joint;
}

void take_limits(const DhRows& rows, std::size_t row, Joint& joint) {
  const bool is_length = joint.type == JointType::Prismatic;
  const auto number = [&](const char* name) {
    return rows.has(name) ? rows.number(row, name, is_length) : 0;
  };
  joint.min = number("min");
  joint.max = number("max");
  if (rows.has("min") && rows.has("max") && joint.min >= joint.max)
    rows.fail(row, "min", "expected less than max");
  joint.speed = number("speed");
  joint.acceleration = number("acceleration");
  assume_limits(joint);
}

/// A standard row has no beta, and its last one no frame of its own behind it.
void expect_standard(const RobotModel& robot) {
  const auto fail = [&](const std::string& what) {
    throw ConfigError{robot.name + ": a standard DH table cannot hold " + what + ". Export a modified one."};
  };
  if (robot.joints[0].a_mm != 0 || robot.joints[0].alpha_rad != 0) fail("a and alpha in front of joint 1");
  if (std::ranges::any_of(robot.joints, [](const Joint& joint) { return joint.beta_rad != 0; })) fail("beta");
  const Eigen::Vector3d p = robot.X_flange.translation(), turns = angles_zyx(robot.X_flange.linear());
  if (std::hypot(p.y(), p.z()) > 1e-9 || std::hypot(turns.y(), turns.z()) > 1e-12) fail("this flange");
}

/// The flange as rows without a joint: shifts along x and z, along y where it has one, and its turn.
std::vector<Joint> flange_rows(const Eigen::Isometry3d& X) {
  constexpr double kRightAngle = std::numbers::pi / 2;
  const Eigen::Vector3d p = X.translation();
  const bool aside = p.y() != 0;
  std::vector<Joint> rows{{.a_mm = p.x(), .d_mm = p.z(), .theta_rad = aside ? kRightAngle : 0}};
  if (aside) rows.push_back({.a_mm = p.y(), .theta_rad = -kRightAngle});
  const Eigen::Vector3d yxz = X.linear().eulerAngles(1, 0, 2);
  rows.push_back({.alpha_rad = yxz[1], .theta_rad = yxz[2], .beta_rad = yxz[0]});
  return rows;
}

/// A column of a table that is written.
struct WrittenColumn {
  const char* header;
  double (*number)(const Joint& row);
};
constexpr WrittenColumn kA{"a (mm)", [](const Joint&row) { return row.a_mm; }},
    kAlpha{"alpha (deg)", [](const Joint&row) { return row.alpha_rad * kDegPerRad; }},
    kD{"d (mm)", [](const Joint&row) { return row.d_mm; }},
    kTheta{"theta (deg)", [](const Joint&row) { return row.theta_rad * kDegPerRad; }},
    kBeta{"beta (deg)", [](const Joint&row) { return row.beta_rad * kDegPerRad; }},
    kSign{"sign", [](const Joint&row) { return row.sign; }},
    kSense{"sense", [](const Joint&row) { return row.sign; }},
    kMin{"min (deg|mm)", [](const Joint&row) { return row.min / unit_of(row); }},
    kMax{"max (deg|mm)", [](const Joint&row) { return row.max / unit_of(row); }},
    kSpeed{"speed (deg/s|mm/s)", [](const Joint&row) { return row.speed / unit_of(row); }},
    kAcceleration{"acceleration (deg/s2|mm/s2)",
                  [](const Joint&row) { return row.acceleration / unit_of(row); }};

struct NamedRow {
  std::string name;
  Joint row;
};

void add_flange(const RobotModel& robot, std::vector<NamedRow>& rows) {
  for (const Joint& row : flange_rows(robot.X_flange)) rows.push_back({"flange", row});
}

std::string table_text(const std::vector<NamedRow>& rows, const std::vector<WrittenColumn>& columns) {
  std::string text = "joint,type";
  for (const WrittenColumn& column : columns) text += std::string{","} + column.header;
  text += '\n';
  for (const auto& [name, row] : rows) {
    text += name + (row.type == JointType::Prismatic ? ",prismatic" : ",revolute");
    for (const WrittenColumn& column : columns) text += ',' + format_number(column.number(row));
    text += '\n';
  }
  return text;
}

}  // namespace

std::optional<DhUnits> dh_units(std::string_view text) {
  const std::size_t comma = text.find(',');
  const Unit* length = unit_named(text.substr(0, comma));
  const Unit* angle = comma == std::string_view::npos ? nullptr : unit_named(text.substr(comma + 1));
  if (!length || !angle || length->quantity != Quantity::Length || angle->quantity != Quantity::Angle)
    return std::nullopt;
  return DhUnits{length->factor, angle->factor};
}

ImportedArm load_dh_table(const std::filesystem::path& file, DhConvention convention,
                          const std::optional<DhUnits>& units) {
  const DhRows rows{file, units};
  const bool standard = convention == DhConvention::Standard;
  ImportedArm arm;
  arm.robot.name = file.stem().string();
  Joint before;  // a and alpha of a standard row stand behind its joint: they are the next row's
  for (std::size_t row = 0; row < rows.size(); ++row) {
    Joint joint = joint_of(rows, row);
    if (is_flange(rows, row)) {
      if (standard) rows.fail(row, "joint", "only a modified table has rows of the flange");
      arm.robot.X_flange = arm.robot.X_flange * link_transform(joint, 0);
      continue;
    }
    if (row > 0 && is_flange(rows, row - 1)) rows.fail(row, "joint", "the rows of the flange come last");
    if (standard) {
      if (joint.beta_rad != 0) rows.fail(row, "beta", "a standard table has no beta");
      std::swap(joint.a_mm, before.a_mm);
      std::swap(joint.alpha_rad, before.alpha_rad);
    }
    take_limits(rows, row, joint);
    arm.robot.joints.push_back(joint);
  }
  if (arm.robot.joints.empty() || arm.robot.joints.size() > static_cast<std::size_t>(kMaxJoints))
    throw ConfigError{file.string() + ": expected 1.." + std::to_string(kMaxJoints) + " joints, found " +
                      std::to_string(arm.robot.joints.size())};
  if (standard) arm.robot.X_flange = link_transform(before, 0);
  if (!rows.has("min") || !rows.has("max") || !rows.has("speed"))
    arm.notes.push_back("no limits or speeds in the table: enter those of the data sheet");
  return arm;
}

std::string dh_table_text(const RobotModel& robot, DhConvention convention) {
  const bool standard = convention == DhConvention::Standard;
  if (standard) expect_standard(robot);
  std::vector<NamedRow> rows;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    Joint row = robot.joints[i];
    if (standard) {
      const bool last = i + 1 == robot.joints.size();
      row.a_mm = last ? robot.X_flange.translation().x() : robot.joints[i + 1].a_mm;
      row.alpha_rad = last ? angles_zyx(robot.X_flange.linear()).x() : robot.joints[i + 1].alpha_rad;
    }
    rows.push_back({std::to_string(i + 1), row});
  }
  if (!standard) add_flange(robot, rows);
  return table_text(rows, {kA, kAlpha, kD, kTheta, kBeta, kSign, kMin, kMax, kSpeed, kAcceleration});
}

std::string robodk_table_text(const RobotModel& robot) {
  std::vector<NamedRow> rows;
  for (std::size_t i = 0; i < robot.joints.size(); ++i)
    rows.push_back({std::to_string(i + 1), robot.joints[i]});
  add_flange(robot, rows);
  return table_text(rows, {kAlpha, kA, kTheta, kD, kBeta, kSense, kMin, kMax, kSpeed});
}

}  // namespace truepose::config
