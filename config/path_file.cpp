#include "config/path_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "config/number_text.hpp"
#include "config/table/csv_reader.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/quality/drive_lag.hpp"

namespace truepose::config {
namespace {

constexpr std::size_t kMostSamples =
    60'000;  // 20 minutes; a report carries them in one array of at most 65,536
constexpr std::size_t kMostPrograms = 20;
constexpr int kFarthest_mm = 100'000, kGreatest_deg = 360,
              kGreatestAxis_deg = 3600;  // beyond is a slip of unit or of a digit

class PathColumns {
 public:
  PathColumns(const CsvTable& table, Eigen::Index joints)
      : table_(table),
        time_(table.column("time_s")),
        program_(table.column("program")),
        point_(table.column("point")),
        gain_(table.column("gain_percent")),
        flange_(columns_of({"flange_x_mm", "flange_y_mm", "flange_z_mm"})),
        abc_(columns_of({"flange_a_deg", "flange_b_deg", "flange_c_deg"})),
        with_(columns_of({"with_x_mm", "with_y_mm", "with_z_mm"})),
        without_(columns_of({"without_x_mm", "without_y_mm", "without_z_mm"})) {
    if (!table.has("set_a1_deg")) return;
    for (const char* name : {"set", "correction", "actual"}) {
      auto& columns = axes_.emplace_back();
      for (Eigen::Index i = 1; i <= joints; ++i)
        columns.push_back(table.column(name + std::string{"_a"} + std::to_string(i) + "_deg"));
    }
  }

  PathSample at(std::size_t row, const Eigen::Isometry3d& X_BW, const Eigen::Vector3d& p_FS_mm) const {
    const Eigen::Isometry3d X_BF =
        pose_from_kuka(vector(row, flange_, kFarthest_mm), vector(row, abc_, kGreatest_deg));
    return {.time_s = time_s(row),
            .at_point = at_point(row),
            .gain_percent = gain_percent(row),
            .wanted_mm = X_BF * p_FS_mm,
            .with_mm = X_BW * vector(row, with_, kFarthest_mm),
            .without_mm = X_BW * vector(row, without_, kFarthest_mm)};
  }

  bool has_axes() const { return !axes_.empty(); }
  AxisSample axes_at(std::size_t row) const {
    return {time_s(row), axes(row, axes_[0]), axes(row, axes_[1]), axes(row, axes_[2])};
  }

  void add_program(std::size_t row, std::vector<std::string>& names) const {
    const std::string name{table_.text(row, program_)};
    if (name.empty()) table_.fail(row, program_, "missing, expected a name");
    if (std::ranges::find(names, name) != names.end()) return;
    if (names.size() == kMostPrograms)
      table_.fail(row, program_, "more than " + std::to_string(kMostPrograms) + " programs in one file");
    names.push_back(name);
  }

 private:
  using Columns = std::array<std::size_t, 3>;

  Columns columns_of(const std::array<const char*, 3>& names) const {
    return {table_.column(names[0]), table_.column(names[1]), table_.column(names[2])};
  }

  [[noreturn]] void fail(std::size_t row, std::size_t column, const std::string& expected) const {
    table_.fail(row, column, "expected " + expected + ", found " + in_quotes(table_.text(row, column)));
  }

  double time_s(std::size_t row) const {
    const double time_s = table_.number(row, time_);
    if (row > 0 && time_s < table_.number(row - 1, time_))
      fail(row, time_, "no time before that of the row above");
    return time_s;
  }

  bool at_point(std::size_t row) const {
    const std::string_view text = table_.text(row, point_);
    if (text != "0" && text != "1") fail(row, point_, "0 or 1");
    return text == "1";
  }

  double gain_percent(std::size_t row) const {
    const double gain = table_.number(row, gain_);
    if (gain > 100) fail(row, gain_, "100 at most");
    return gain;
  }

  double number(std::size_t row, std::size_t column, int greatest) const {
    const double number = table_.number(row, column);
    if (std::abs(number) > greatest)
      fail(row, column, "-" + std::to_string(greatest) + ".." + std::to_string(greatest));
    return number;
  }

  Eigen::Vector3d vector(std::size_t row, const Columns& columns, int greatest) const {
    return {number(row, columns[0], greatest), number(row, columns[1], greatest),
            number(row, columns[2], greatest)};
  }

  JointVector axes(std::size_t row, const std::vector<std::size_t>& columns) const {
    JointVector q(static_cast<Eigen::Index>(columns.size()));
    for (std::size_t i = 0; i < columns.size(); ++i)
      q[static_cast<Eigen::Index>(i)] = number(row, columns[i], kGreatestAxis_deg) * kRadPerDeg;
    return q;
  }

  const CsvTable& table_;
  std::size_t time_, program_, point_, gain_;
  Columns flange_, abc_, with_, without_;
  std::vector<std::vector<std::size_t>> axes_;  // set, correction, actual; empty where the file has none
};

/// Identifies the drives' lag from the rows between the points, and applies it to the wanted path. At a point
/// the arm stands, so the lag changes nothing there.
void apply_lag(ProductionPath& path, const PathColumns& columns, const PathFrame& frame) {
  std::vector<AxisSample> axes;
  std::vector<PathSample*> samples;
  for (std::size_t row = 0; row < path.samples.size(); ++row) {
    PathSample& sample = path.samples[row];
    sample.lagged_mm = sample.wanted_mm;
    if (sample.at_point) continue;
    axes.push_back(columns.axes_at(row));
    samples.push_back(&sample);
  }
  path.lag = identify_drive_lag(axes);
  const std::vector<JointVector> lagged = lagged_set_points(axes, *path.lag);
  for (std::size_t i = 0; i < lagged.size(); ++i)
    samples[i]->lagged_mm = forward_kinematics(frame.nominal, lagged[i]) * frame.p_FS_mm;
}

}  // namespace

ProductionPath load_production_path(const std::filesystem::path& file, const PathFrame& frame) {
  const CsvTable table = CsvTable::read(file);
  const PathColumns columns(table, frame.nominal.joint_count());
  if (table.row_count() > kMostSamples)
    table.fail("more than " + std::to_string(kMostSamples) +
               " rows of data, 20 minutes: record a shorter time");
  const Eigen::Isometry3d X_BW = frame.X_WB.inverse();
  ProductionPath path;
  std::vector<std::string> programs;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    path.samples.push_back(columns.at(row, X_BW, frame.p_FS_mm));
    columns.add_program(row, programs);
  }
  for (const std::string& name : programs) path.program += (path.program.empty() ? "" : ", ") + name;
  if (columns.has_axes()) apply_lag(path, columns, frame);
  return path;
}

}  // namespace truepose::config
