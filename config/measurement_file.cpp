#include "config/measurement_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "config/number_text.hpp"
#include "config/table/csv_reader.hpp"
#include "config/table/table_reading.hpp"
#include "config/table/turn_columns.hpp"
#include "core/calibrate/option_names.hpp"
#include "core/data/measured_time.hpp"
#include "core/formatted.hpp"

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

std::vector<std::string> joint_column_names(std::string_view prefix, std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= count; ++i) names.push_back(std::string(prefix) + std::to_string(i));
  return names;
}

std::vector<std::string> joint_column_names(std::string_view prefix, const RobotModel& robot) {
  return joint_column_names(prefix, robot.joints.size());
}

namespace {

constexpr int kGreatestSigma_mm = 1000;
constexpr double kGreatestPose = 1e9;
constexpr int kGreatestPayload_kg = 100'000;
/// What the flange carried: kg, and its centre in the flange frame, mm.
constexpr std::array<std::string_view, 4> kPayloadColumns{"payload_kg", "payload_x", "payload_y",
                                                          "payload_z"};
constexpr int kColdest_c = -50, kHottest_c = 200;  // of a drive
constexpr double kFastestPose_s = 0.01;            // no arm comes to poses faster
/// What a form of time is called in an error.
constexpr std::array kTimeForms{Named{"a number of seconds", TimeForm::Number},
                                Named{"a date without a zone", TimeForm::Local},
                                Named{"a date with a zone", TimeForm::Zoned}};

constexpr std::size_t kMostReflectors = 100;

/// The columns q1..qN of a table. Throws ConfigError where one is missing.
class JointColumns {
 public:
  JointColumns(const CsvTable& table, const RobotModel& robot) : table_(table), robot_(robot) {
    for (const std::string& name : joint_column_names("q", robot)) columns_.push_back(table.column(name));
  }
  JointVector at(std::size_t row) const {
    std::vector<double> deg_mm;
    for (const std::size_t column : columns_) deg_mm.push_back(table_.number(row, column));
    return joints_from(deg_mm, robot_);
  }

 private:
  const CsvTable& table_;
  const RobotModel& robot_;
  std::vector<std::size_t> columns_;
};

/// The columns of a measurement file. An optional field may be empty: not known.
class MeasurementColumns {
 public:
  MeasurementColumns(const CsvTable& table, const RobotModel& robot)
      : table_(table),
        q_(table, robot),
        x_(table.column("x")),
        y_(table.column("y")),
        z_(table.column("z")),
        turn_(table) {
    directions_ = all_or_none(joint_column_names("dir", robot));
    temperatures_ = all_or_none(joint_column_names("temp", robot));
    payload_ = all_or_none(kPayloadColumns);
    if (table_.has("time")) find_time(table_.column("time"));
  }

  Measurement at(std::size_t row, std::vector<std::string>& smr_names) const {
    Measurement point;
    point.row = static_cast<int>(row) + 1;
    point.q = q_.at(row);
    point.p_WS_mm = position_mm(row);
    point.smr = reflector_index(smr_names, row);
    point.set = set(row);
    point.in_order = point.set == PoseSet::Identify;
    point.sigma_mm = sigma_mm(row);
    point.excess_mm = excess_mm(row);
    point.direction = direction(row);
    point.payload = payload(row);
    point.orientation = turn_.at(row);
    point.temperature_c = temperature_c(row);
    if (time_) point.time = time(row);
    if (table_.has("pose")) point.pose = pose(row);
    return point;
  }

 private:
  /// Columns of all these names, where there is one of any.
  template <class Names>
  std::vector<std::size_t> all_or_none(const Names& names) const {
    std::vector<std::size_t> columns;
    if (std::ranges::none_of(names, [&](std::string_view name) { return table_.has(name); })) return columns;
    for (const auto& name : names) columns.push_back(table_.column(name));
    return columns;
  }

  Eigen::Vector3d position_mm(std::size_t row) const {
    const Eigen::Vector3d p_mm{table_.number(row, x_), table_.number(row, y_), table_.number(row, z_)};
    if (p_mm.isZero(0)) {
      table_.fail(row, x_,
                  "x, y and z are all 0, which is no reading but a place left empty: remove the row or "
                  "measure it again");
    }
    return p_mm;
  }

  int reflector_index(std::vector<std::string>& names, std::size_t row) const {
    const std::string name = smr(row);
    const auto found = std::ranges::find(names, name);
    const auto index = static_cast<int>(found - names.begin());
    if (found != names.end()) return index;
    if (names.size() == kMostReflectors) {
      table_.fail(row, table_.column("smr"),
                  "more than " + std::to_string(kMostReflectors) + " reflectors in one file");
    }
    names.push_back(name);
    return index;
  }

  std::string smr(std::size_t row) const {
    if (!table_.has("smr")) return "1";
    const std::size_t column = table_.column("smr");
    if (table_.text(row, column).empty()) table_.fail(row, column, "missing, expected a reflector's name");
    return std::string(table_.text(row, column));
  }

  PoseSet set(std::size_t row) const {
    if (!table_.has("set")) return PoseSet::Identify;
    const std::size_t column = table_.column("set");
    const std::string_view word = table_.text(row, column);
    const auto* const named = std::ranges::find(kPoseSetNames, word, &Named<PoseSet>::name);
    if (named == kPoseSetNames.end())
      table_.fail(row, column, "expected identify or validate, found " + in_quotes(word));
    return named->value;
  }

  /// Of a column that may be empty.
  std::optional<double> length_mm(std::size_t row, std::size_t column) const {
    if (table_.text(row, column).empty()) return std::nullopt;
    return table_.number(row, column);
  }

  std::optional<double> sigma_mm(std::size_t row) const {
    if (!table_.has("sigma")) return std::nullopt;
    const std::size_t column = table_.column("sigma");
    const auto sigma = length_mm(row, column);
    if (sigma && (*sigma <= 0 || *sigma > kGreatestSigma_mm)) {
      table_.fail(row, column,
                  "expected more than 0 and at most " + std::to_string(kGreatestSigma_mm) + " mm, found " +
                      std::string(table_.text(row, column)));
    }
    return sigma;
  }

  double excess_mm(std::size_t row) const {
    if (!table_.has("excess")) return 0;
    const std::size_t column = table_.column("excess");
    const double excess = length_mm(row, column).value_or(0);
    if (excess < 0 || excess > kGreatestSigma_mm)
      table_.fail(row, column,
                  "expected 0 to " + std::to_string(kGreatestSigma_mm) + " mm, found " +
                      std::string(table_.text(row, column)));
    return excess;
  }

  std::vector<std::int8_t> direction(std::size_t row) const {
    const auto empty = [&](std::size_t column) { return table_.text(row, column).empty(); };
    if (std::ranges::all_of(directions_, empty)) return {};
    std::vector<std::int8_t> direction;
    for (const std::size_t column : directions_) {
      const double side = table_.number(row, column);
      if (side != -1 && side != 0 && side != 1) {
        table_.fail(row, column, "expected -1, 0 or 1, found " + std::string(table_.text(row, column)));
      }
      direction.push_back(static_cast<std::int8_t>(side));
    }
    return direction;
  }

  std::optional<LinkMass> payload(std::size_t row) const {
    const auto empty = [&](std::size_t column) { return table_.text(row, column).empty(); };
    if (std::ranges::all_of(payload_, empty)) return std::nullopt;
    const auto number = [&](std::size_t k) { return table_.number(row, payload_[k]); };
    const double kg = number(0);
    if (kg < 0 || kg > kGreatestPayload_kg) {
      table_.fail(row, payload_[0],
                  "expected 0 to " + std::to_string(kGreatestPayload_kg) + " kg, found " +
                      std::string(table_.text(row, payload_[0])));
    }
    return LinkMass{kg, {number(1), number(2), number(3)}};
  }

  std::vector<double> temperature_c(std::size_t row) const {
    const auto empty = [&](std::size_t column) { return table_.text(row, column).empty(); };
    if (std::ranges::all_of(temperatures_, empty)) return {};
    std::vector<double> temperature_c;
    for (const std::size_t column : temperatures_) {
      const double celsius = table_.number(row, column);
      if (celsius < kColdest_c || celsius > kHottest_c) {
        table_.fail(row, column,
                    "expected a temperature of " + std::to_string(kColdest_c) + " to " +
                        std::to_string(kHottest_c) + " C, found " + std::string(table_.text(row, column)));
      }
      temperature_c.push_back(celsius);
    }
    return temperature_c;
  }

  /// A column that is empty throughout is none.
  void find_time(std::size_t column) {
    for (std::size_t row = 0; row < table_.row_count() && !time_; ++row)
      if (!table_.text(row, column).empty()) time_ = column;
  }

  std::string time(std::size_t row) const {
    const std::string_view text = table_.text(row, *time_);
    if (text.empty())
      table_.fail(row, *time_,
                  "missing, where other rows have it: give every row its time or remove the column");
    const auto time = measured_time(text), first = measured_time(table_.text(0, *time_));
    if (!time) {
      table_.fail(
          row, *time_,
          "expected 2026-11-26T08:00:30 (T or a blank, with or without a fraction and a zone, Z or +01:00) "
          "or a number of seconds, found " +
              in_quotes(text));
    }
    if (first->form != time->form) {
      table_.fail(row, *time_,
                  std::string(name_of(kTimeForms, time->form)) + ", where row 1 has " +
                      std::string(name_of(kTimeForms, first->form)) + ": write all times in one form");
    }
    return std::string(text);
  }

  int pose(std::size_t row) const {
    const std::size_t column = table_.column("pose");
    const double number = table_.number(row, column);
    if (number < 1 || number > kGreatestPose || number != std::floor(number)) {
      table_.fail(row, column,
                  "expected a whole number of 1 or more, found " + std::string(table_.text(row, column)));
    }
    return static_cast<int>(number);
  }

  const CsvTable& table_;
  JointColumns q_;
  std::size_t x_, y_, z_;
  std::vector<std::size_t> directions_, payload_, temperatures_;
  TurnColumns turn_;
  std::optional<std::size_t> time_;
};

/// A spreadsheet counts days, and a column may say the same in every row.
void refuse_numbers_that_are_no_seconds(const CsvTable& table, const MeasurementData& data) {
  std::vector<double> seconds;
  for (const Measurement& point : data.points) {
    const auto time = measured_time(point.time);
    if (!time || time->form != TimeForm::Number) return;
    seconds.push_back(time->seconds);
  }
  const auto [first, last] = std::ranges::minmax(seconds);
  const int poses = count_poses(data.points);
  if (last - first >= kFastestPose_s * (poses - 1)) return;
  table.fail(
      formatted("time: numbers are seconds, and %d poses within %.3g s are not possible: write days of a "
                "spreadsheet as 2026-11-26T08:00:30",
                poses, last - first));
}

}  // namespace

std::vector<JointVector> load_joints(const std::filesystem::path& file, const RobotModel& robot,
                                     const TableReading* reading) {
  const std::vector<std::string> joint_names = joint_column_names("q", robot);
  std::vector<std::string> known = joint_names;
  known.insert(known.end(), kReachColumns.begin(), kReachColumns.end());
  const CsvTable table = read_table(file, {known, {joint_names}, &robot}, reading);
  table.expect_only(known);
  const JointColumns columns(table, robot);
  std::vector<JointVector> joints;
  for (std::size_t row = 0; row < table.row_count(); ++row) joints.push_back(columns.at(row));
  return joints;
}

void write_joints(std::ostream& out, const std::vector<JointVector>& joints, const RobotModel& robot) {
  const std::vector<std::string> names = joint_column_names("q", robot);
  for (std::size_t i = 0; i < names.size(); ++i) out << (i ? "," : "") << names[i];
  out << '\n';
  for (const JointVector& q : joints) {
    for (int i = 0; i < robot.joint_count(); ++i) {
      out << (i ? "," : "") << joint_field(q[i], robot.joints[static_cast<std::size_t>(i)]);
    }
    out << '\n';
  }
}

MeasurementData load_measurements(const std::filesystem::path& file, const RobotModel& robot,
                                  const TableReading* reading) {
  std::vector<std::string> known = joint_column_names("q", robot);
  known.insert(known.end(), {"x", "y", "z"});
  const std::vector<std::string> needed = known;
  known.insert(known.end(), {"smr", "set", "sigma", "excess", "time", "pose"});
  for (const char* prefix : {"dir", "temp"}) {
    const std::vector<std::string> names = joint_column_names(prefix, robot);
    known.insert(known.end(), names.begin(), names.end());
  }
  known.insert(known.end(), kPayloadColumns.begin(), kPayloadColumns.end());
  known.insert(known.end(), kTurnColumns.begin(), kTurnColumns.end());
  const CsvTable table = read_table(file, {known, {needed}, &robot}, reading);
  table.expect_only(known);

  const MeasurementColumns columns(table, robot);
  MeasurementData data;
  for (std::size_t row = 0; row < table.row_count(); ++row)
    data.points.push_back(columns.at(row, data.smr_names));
  refuse_numbers_that_are_no_seconds(table, data);
  return data;
}

namespace {

/// Four fields, each with its comma.
std::string payload_fields(const std::optional<LinkMass>& payload) {
  if (!payload) return ",,,,";
  std::string fields = format_number(payload->mass_kg) + ",";
  for (const double coordinate : payload->centre_mm) fields += format_number(coordinate) + ",";
  return fields;
}

}  // namespace

void write_measurements(std::ostream& out, const MeasurementData& data, const RobotModel& robot) {
  const bool directions =
      std::ranges::any_of(data.points, [](const auto& point) { return !point.direction.empty(); });
  const bool payloads =
      std::ranges::any_of(data.points, [](const auto& point) { return point.payload.has_value(); });
  const bool temperatures =
      std::ranges::any_of(data.points, [](const auto& point) { return !point.temperature_c.empty(); });
  const bool turns =
      std::ranges::any_of(data.points, [](const auto& point) { return point.orientation.has_value(); });
  const bool excess = std::ranges::any_of(data.points, [](const auto& point) { return point.excess_mm > 0; });
  const bool poses = std::ranges::all_of(data.points, [](const auto& point) { return point.pose > 0; });
  for (const std::string& name : joint_column_names("q", robot)) out << name << ',';
  out << "x,y,z,smr,set,sigma," << (excess ? "excess," : "");
  if (directions) {
    for (const std::string& name : joint_column_names("dir", robot)) out << name << ',';
  }
  if (payloads) {
    for (const std::string_view name : kPayloadColumns) out << name << ',';
  }
  if (turns) {
    for (const std::string_view name : kTurnColumns) out << name << ',';
  }
  if (temperatures) {
    for (const std::string& name : joint_column_names("temp", robot)) out << name << ',';
  }
  out << (poses ? "time,pose\n" : "time\n");

  for (const Measurement& point : data.points) {
    for (int i = 0; i < robot.joint_count(); ++i) {
      out << joint_field(point.q[i], robot.joints[static_cast<std::size_t>(i)]) << ',';
    }
    for (const double coordinate : point.p_WS_mm) out << format_number(coordinate) << ',';
    out << csv_field(data.smr_names[static_cast<std::size_t>(point.smr)]) << ',';
    out << name_of(kPoseSetNames, point.set) << ',';
    out << (point.sigma_mm ? format_number(*point.sigma_mm) : "") << ',';
    if (excess) out << format_number(point.excess_mm) << ',';
    if (directions) {
      for (std::size_t i = 0; i < robot.joints.size(); ++i) {
        out << (point.direction.empty() ? "" : std::to_string(point.direction[i])) << ',';
      }
    }
    if (payloads) out << payload_fields(point.payload);
    if (turns) out << turn_fields(point.orientation) << ',';
    if (temperatures) {
      for (std::size_t i = 0; i < robot.joints.size(); ++i)
        out << (point.temperature_c.empty() ? "" : format_number(point.temperature_c[i])) << ',';
    }
    out << csv_field(point.time);
    if (poses) out << ',' << point.pose;
    out << '\n';
  }
}

}  // namespace truepose::config
