// What a table is understood as, before anything is computed from it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>

#include "config/measurement_file.hpp"
#include "config/number_text.hpp"
#include "config/robot_file.hpp"
#include "config/table/column_name.hpp"
#include "config/table/csv_reader.hpp"
#include "core/arm/joint_units.hpp"
#include "core/diagnosis/unit_mistakes.hpp"
#include "core/formatted.hpp"
#include "core/math/statistics.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/offline/offline_commands.hpp"
#include "tools/truepose/offline/table_options.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

constexpr std::size_t kFirstRows = 3;

struct DataCheck {
  std::string file, robot_file;
  TableOptions table;
  bool as_json = false;
};

struct ColumnRange {
  std::string column;
  double least = 0, greatest = 0;
  int decimals = 0;  ///< the most that a number of it has
};
void layout(record::Io& io, ColumnRange& x) {
  io("column", x.column);
  io("least", x.least);
  io("greatest", x.greatest);
  io("decimals", x.decimals);
}

/// What is printed as JSON.
struct DataSummary {
  std::string read_as;  ///< empty: the file is in truepose's own form
  int rows = 0;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> first_rows;
  std::vector<ColumnRange> ranges;
  std::vector<std::string> findings;
};
void layout(record::Io& io, DataSummary& x) {
  io("read_as", x.read_as);
  io("rows", x.rows);
  io("columns", x.columns);
  io("first_rows", x.first_rows);
  io("ranges", x.ranges);
  io("findings", x.findings);
}

/// All that measurements, joints and points may have.
config::TableForm form_of(const RobotModel* robot) {
  config::TableForm form{.known = {}, .needed = {{"x", "y", "z"}, {"q1"}}, .robot = robot};
  for (const char* prefix : {"q", "dir", "temp"})
    std::ranges::copy(config::joint_column_names(prefix, robot ? robot->joints.size() : kMaxJoints),
                      std::back_inserter(form.known));
  for (const std::string& name : config::own_column_names())
    if (!form.knows(name)) form.known.push_back(name);
  if (robot) form.needed.back() = config::joint_column_names("q", *robot);
  return form;
}

int decimals_of(std::string_view number) {
  const auto point = number.find('.');
  if (point == std::string_view::npos || number.find_first_of("eE") != std::string_view::npos) return 0;
  return static_cast<int>(number.size() - point - 1);
}

std::optional<ColumnRange> range_of(const config::CsvTable& table, const std::string& name) {
  if (config::holds_words(name)) return std::nullopt;
  const std::size_t column = table.column(name);
  std::optional<ColumnRange> range;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    if (table.text(row, column).empty()) continue;
    const double number = table.number(row, column);
    if (!range) range = {name, number, number, 0};
    range->least = std::min(range->least, number);
    range->greatest = std::max(range->greatest, number);
    range->decimals = std::max(range->decimals, decimals_of(table.text(row, column)));
  }
  return range;
}

bool is_joint(const ColumnRange& range) { return range.column[0] == 'q'; }

std::string rows_text(const std::vector<std::size_t>& rows) {
  constexpr std::size_t kMost = 6;
  std::string text = rows.size() == 1 ? "row " : "rows ";
  for (std::size_t k = 0; k < std::min(rows.size(), kMost); ++k)
    text += (k ? ", " : "") + std::to_string(rows[k] + 1);
  return text + (rows.size() > kMost ? ", .. (" + std::to_string(rows.size()) + ")" : "");
}

void find_duplicates(const config::CsvTable& table, std::vector<std::string>& findings) {
  std::map<std::vector<std::string>, std::size_t> first;
  std::vector<std::size_t> again;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    std::vector<std::string> fields;
    for (std::size_t k = 0; k < table.columns().size(); ++k)
      if (table.columns()[k] != "time" && table.columns()[k] != "pose")
        fields.emplace_back(table.text(row, k));
    if (!first.emplace(std::move(fields), row).second) again.push_back(row);
  }
  if (!again.empty())
    findings.push_back(rows_text(again) +
                       ": the same numbers as in a row before: a copy, or a reading twice");
}

void find_coarse_joints(const DataSummary& summary, std::vector<std::string>& findings) {
  constexpr double kReach_mm = 2000;
  int most = -1;
  for (const ColumnRange& range : summary.ranges)
    if (is_joint(range)) most = std::max(most, range.decimals);
  if (most < 0 || most > 1) return;
  const double step_deg = most == 1 ? 0.1 : 1;
  findings.push_back("joints have " + std::to_string(most) + (most == 1 ? " decimal" : " decimals") +
                     formatted(": rounding to %g deg moves a point at 2 m by up to %.1f mm. Export them with "
                               "four decimals",
                               step_deg, step_deg / 2 * kRadPerDeg * kReach_mm));
}

void find_units(const DataSummary& summary, std::vector<std::string>& findings) {
  constexpr double kTurn_rad = 6.2832, kMost_m = 20;
  double joints = 0, points = 0;
  for (const ColumnRange& range : summary.ranges) {
    const double most = std::max(std::abs(range.least), std::abs(range.greatest));
    if (is_joint(range)) joints = std::max(joints, most);
    if (range.column == "x" || range.column == "y" || range.column == "z") points = std::max(points, most);
  }
  if (joints > 0 && joints < kTurn_rad)
    findings.push_back("no joint is beyond " + formatted("%.3g", joints) +
                       ": they look like rad. If they are: --units rad,mm");
  if (points > 0 && points < kMost_m)
    findings.push_back("no coordinate is beyond " + formatted("%.3g", points) +
                       ": they look like m. If they are: --units deg,m");
}

/// Two points of an arm are never farther apart than twice its reach.
void find_far_points(const config::CsvTable& table, const RobotModel& robot,
                     std::vector<std::string>& findings) {
  if (!table.has("x")) return;
  std::array<std::vector<double>, 3> xyz;
  for (std::size_t row = 0; row < table.row_count(); ++row)
    for (std::size_t k = 0; k < 3; ++k)
      xyz[k].push_back(table.number(row, table.column(std::string(1, "xyz"[k]))));
  std::vector<std::size_t> far;
  const double most_mm = 2 * reach_mm(robot);
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    double squares = 0;
    for (const auto& axis : xyz) squares += (axis[row] - median(axis)) * (axis[row] - median(axis));
    if (std::sqrt(squares) > most_mm) far.push_back(row);
  }
  if (!far.empty())
    findings.push_back(
        rows_text(far) +
        formatted(": beyond the arm's reach, more than %.0f mm from the middle of the points", most_mm));
}

void find_joints_beyond_limits(const config::CsvTable& table, const RobotModel& robot,
                               std::vector<std::string>& findings) {
  for (std::size_t k = 0; k < robot.joints.size(); ++k) {
    const std::string name = "q" + std::to_string(k + 1);
    if (!table.has(name)) continue;
    const Joint& joint = robot.joints[k];
    std::vector<std::size_t> beyond;
    for (std::size_t row = 0; row < table.row_count(); ++row) {
      const double q = table.number(row, table.column(name)) * unit_of(joint);
      if (q < joint.min || q > joint.max) beyond.push_back(row);
    }
    if (!beyond.empty())
      findings.push_back(rows_text(beyond) + ": " + name + " is beyond its limits (" +
                         config::joint_field(joint.min, joint) + ".." +
                         config::joint_field(joint.max, joint) + " " + std::string{unit_name(joint)} + ")");
  }
}

DataSummary summary_of(const config::CsvTable& table, const RobotModel* robot, std::string read_as) {
  DataSummary summary{.read_as = std::move(read_as),
                      .rows = static_cast<int>(table.row_count()),
                      .columns = table.columns(),
                      .first_rows = {},
                      .ranges = {},
                      .findings = {}};
  for (std::size_t row = 0; row < std::min(table.row_count(), kFirstRows); ++row) {
    auto& fields = summary.first_rows.emplace_back();
    for (std::size_t k = 0; k < summary.columns.size(); ++k) fields.emplace_back(table.text(row, k));
  }
  for (const std::string& name : summary.columns)
    if (auto range = range_of(table, name)) summary.ranges.push_back(*std::move(range));
  find_units(summary, summary.findings);
  find_duplicates(table, summary.findings);
  find_coarse_joints(summary, summary.findings);
  if (robot) {
    find_far_points(table, *robot, summary.findings);
    find_joints_beyond_limits(table, *robot, summary.findings);
  }
  return summary;
}

void print_data(const DataSummary& summary) {
  std::vector<Cells> rows{summary.columns}, ranges{{"column", "least", "greatest", "decimals"}};
  rows.insert(rows.end(), summary.first_rows.begin(), summary.first_rows.end());
  for (const ColumnRange& each : summary.ranges)
    ranges.push_back({each.column, config::format_number(each.least), config::format_number(each.greatest),
                      std::to_string(each.decimals)});
  std::printf("%d rows, the first ones (deg, mm):\n%s\n%s", summary.rows, text_table(rows).c_str(),
              text_table(ranges).c_str());
  for (const std::string& finding : summary.findings) std::printf("! %s\n", finding.c_str());
}

int run_data_check(const DataCheck& command) {
  std::optional<RobotModel> robot;
  if (!command.robot_file.empty()) robot = config::load_robot(command.robot_file);
  config::TableReading reading = reading_of(command.table);
  std::string read_as;
  reading.report = [&](const std::string& line) {
    if (!command.as_json) print_to_stderr(line);
    read_as += (read_as.empty() ? "" : "; ") + line;
  };
  const RobotModel* arm = robot ? &*robot : nullptr;
  const config::CsvTable table = config::read_table(command.file, form_of(arm), &reading);
  const DataSummary summary = summary_of(table, arm, read_as);
  if (command.as_json)
    std::cout << control::json_text(record::to_json(summary)) << '\n';
  else
    print_data(summary);
  return summary.findings.empty() ? kDone : kFailed;
}

}  // namespace

Command data_commands() { return {.name = "data", .help = "Measurement files"}; }

Command data_check_command() {
  const auto command = std::make_shared<DataCheck>();
  DataCheck& c = *command;
  return {.name = "data check",
          .help = "Shows what a file of measurements, joints or points is understood as",
          .options = {Option("file", &c.file,
                             "Table (CSV, or as Excel, a controller or a tracker's program writes it)",
                             {.required = true, .type = "FILE", .file = FileUse::Read}),
                      Option("--robot", &c.robot_file, "Robot file (YAML), for joint limits and reach",
                             {.file = FileUse::Read}),
                      columns_option(c.table), units_option(c.table),
                      Option("--json", &c.as_json, "One JSON document")},
          .run = [command] { return run_data_check(*command); },
          .examples = {{"data check points.csv --robot arm.yaml"}}};
}

}  // namespace truepose::tools
