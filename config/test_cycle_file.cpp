#include "config/test_cycle_file.hpp"

#include <algorithm>
#include <array>
#include <expected>
#include <map>
#include <optional>
#include <set>

#include "config/table/csv_reader.hpp"
#include "config/table/table_reading.hpp"
#include "core/math/angles.hpp"
#include "core/math/rigid_fit.hpp"

namespace truepose::config {
namespace {

/// Poses by the point they belong to, then by reflector.
using PosesOfReflectors = std::map<std::string, TestPose>;
using CommandedPoses = std::map<std::string, PosesOfReflectors>;

/// A column that may be absent: its text is then empty.
class OptionalColumn {
 public:
  OptionalColumn(const CsvTable& table, std::string_view name)
      : table_(table), column_(table.has(name) ? std::optional(table.column(name)) : std::nullopt) {}
  std::string at(std::size_t row) const {
    return column_ ? std::string(table_.text(row, *column_)) : std::string();
  }

 private:
  const CsvTable& table_;
  std::optional<std::size_t> column_;
};

/// A column of names that must not be empty.
class NameColumn {
 public:
  NameColumn(const CsvTable& table, std::string_view name) : table_(table), column_(table.column(name)) {}
  std::string at(std::size_t row) const {
    const std::string_view text = table_.text(row, column_);
    if (text.empty()) table_.fail(row, column_, "missing, expected a name");
    return std::string(text);
  }
  [[noreturn]] void fail(std::size_t row, std::string_view what) const { table_.fail(row, column_, what); }

 private:
  const CsvTable& table_;
  std::size_t column_;
};

/// The columns x,y,z and, where one of them is there, a,b,c; all behind a prefix.
class PoseColumns {
 public:
  PoseColumns(const CsvTable& table, const std::string& prefix) : table_(table) {
    for (const char* name : {"x", "y", "z"}) columns_.push_back(table.column(prefix + name));
    const auto has = [&](const char* name) { return table.has(prefix + name); };
    if (!has("a") && !has("b") && !has("c")) return;
    for (const char* name : {"a", "b", "c"}) columns_.push_back(table.column(prefix + name));
  }

  TestPose at(std::size_t row) const {
    const auto number = [&](std::size_t i) { return table_.number(row, columns_[i]); };
    TestPose pose{.p_mm = {number(0), number(1), number(2)}};
    if (columns_.size() > 3) pose.R = pose_from_kuka({0, 0, 0}, {number(3), number(4), number(5)}).linear();
    return pose;
  }

 private:
  const CsvTable& table_;
  std::vector<std::size_t> columns_;
};

bool same(const TestPose& a, const TestPose& b) {
  return a.p_mm == b.p_mm && a.R.has_value() == b.R.has_value() && (!a.R || *a.R == *b.R);
}

CommandedPoses read_targets(const std::filesystem::path& file, const TableReading* reading) {
  const std::vector<std::string> known{"point", "smr", "x", "y", "z", "a", "b", "c"};
  const CsvTable table = read_table(file, {known, {{"point", "x", "y", "z"}}}, reading);
  table.expect_only(known);
  const NameColumn point(table, "point");
  const OptionalColumn smr(table, "smr");
  const PoseColumns pose(table, "");
  CommandedPoses commanded;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    if (!commanded[point.at(row)].emplace(smr.at(row), pose.at(row)).second)
      point.fail(row, point.at(row) + " is there twice");
  }
  return commanded;
}

/// The commanded poses that the rows of the data themselves state.
CommandedPoses commanded_columns(const CsvTable& table) {
  if (!table.has("cx"))
    table.fail("no commanded poses: give them as columns cx,cy,cz or in a file of their own");
  const NameColumn point(table, "point");
  const OptionalColumn smr(table, "smr");
  const PoseColumns pose(table, "c");
  CommandedPoses commanded;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    const auto& known = commanded[point.at(row)].emplace(smr.at(row), pose.at(row)).first->second;
    if (!same(known, pose.at(row)))
      point.fail(row, "another row of " + point.at(row) + " commands another pose");
  }
  return commanded;
}

/// What was measured in one cycle, and where the first row of it is.
struct Cycle {
  std::string point, cycle, direction, series;
  std::size_t row = 0;
  PosesOfReflectors measured;
};

std::vector<Cycle> read_cycles(const CsvTable& table) {
  const NameColumn point(table, "point"), cycle(table, "cycle");
  const OptionalColumn smr(table, "smr"), direction(table, "direction"), time(table, "time");
  const PoseColumns pose(table, "");
  std::vector<Cycle> cycles;
  std::map<std::array<std::string, 4>, std::size_t> index;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    const std::array key{point.at(row), cycle.at(row), direction.at(row), time.at(row)};
    const auto [found, is_new] = index.emplace(key, cycles.size());
    if (is_new) cycles.push_back({key[0], key[1], key[2], key[3], row, {}});
    if (!cycles[found->second].measured.emplace(smr.at(row), pose.at(row)).second)
      cycle.fail(row, "cycle " + key[1] + " of " + key[0] + " is there twice");
  }
  return cycles;
}

TestPose mean_position(const PosesOfReflectors& reflectors) {
  TestPose mean;
  for (const auto& [name, pose] : reflectors) mean.p_mm += pose.p_mm / static_cast<double>(reflectors.size());
  return mean;
}

/// The commanded pose of several reflectors together.
TestPose commanded_pose(const PosesOfReflectors& reflectors) {
  if (reflectors.size() == 1) return reflectors.begin()->second;
  TestPose pose = mean_position(reflectors);
  pose.R = Eigen::Matrix3d::Identity();
  return pose;
}

/// The pose that the reflectors of a cycle show, or one sentence.
std::expected<TestPose, std::string> attained_pose(const PosesOfReflectors& commanded, const Cycle& cycle) {
  std::vector<Eigen::Vector3d> from, to;
  for (const auto& [name, pose] : commanded) {
    const auto found = cycle.measured.find(name);
    if (found == cycle.measured.end())
      return std::unexpected("cycle " + cycle.cycle + " of " + cycle.point + " lacks reflector '" + name +
                             "'");
    from.push_back(pose.p_mm);
    to.push_back(found->second.p_mm);
  }
  for (const auto& [name, pose] : cycle.measured) {
    if (!commanded.contains(name))
      return std::unexpected("no commanded pose of " + cycle.point + " for reflector '" + name + "'");
  }
  if (commanded.size() == 1) return cycle.measured.begin()->second;
  const auto X = rigid_fit(from, to);
  if (!X) return std::unexpected("the reflectors show no orientation: " + X.error());
  TestPose pose = mean_position(cycle.measured);
  pose.R = X->linear();
  return pose;
}

/// There is nothing to compare it with.
void leave_out_single_series(std::vector<TestPoint>& points) {
  std::set<std::string> series;
  for (const TestPoint& point : points)
    for (const AttainedPose& attained : point.attained) series.insert(attained.series);
  if (series.size() > 1) return;
  for (TestPoint& point : points)
    for (AttainedPose& attained : point.attained) attained.series.clear();
}

}  // namespace

std::vector<TestPoint> load_test_cycles(const std::filesystem::path& data,
                                        const std::filesystem::path& targets, const TableReading* reading) {
  const std::vector<std::string> known{"point",     "cycle", "x",  "y",  "z",  "a",  "b",  "c", "smr",
                                       "direction", "time",  "cx", "cy", "cz", "ca", "cb", "cc"};
  const CsvTable table = read_table(data, {known, {{"point", "cycle", "x", "y", "z"}}}, reading);
  table.expect_only(known);
  const CommandedPoses commanded =
      targets.empty() ? commanded_columns(table) : read_targets(targets, reading);
  const std::size_t column = table.column("point");
  std::vector<TestPoint> points;
  for (const auto& [name, reflectors] : commanded) points.push_back({name, commanded_pose(reflectors), {}});
  for (const Cycle& cycle : read_cycles(table)) {
    const auto of_point = commanded.find(cycle.point);
    if (of_point == commanded.end()) table.fail(cycle.row, column, "no commanded pose of " + cycle.point);
    const auto pose = attained_pose(of_point->second, cycle);
    if (!pose) table.fail(cycle.row, column, pose.error());
    std::ranges::find(points, cycle.point, &TestPoint::name)
        ->attained.push_back({*pose, cycle.direction, cycle.series});
  }
  leave_out_single_series(points);
  return points;
}

}  // namespace truepose::config
