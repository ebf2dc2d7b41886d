#include "config/frame_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "config/frame_layout.hpp"
#include "config/lower_triangle.hpp"
#include "config/measurement_file.hpp"
#include "config/model_file.hpp"
#include "config/number_text.hpp"
#include "config/sealed_text.hpp"
#include "config/table/csv_reader.hpp"
#include "config/table/table_reading.hpp"
#include "config/table/turn_columns.hpp"
#include "config/text_file.hpp"
#include "core/arm/joint_units.hpp"
#include "core/formatted.hpp"
#include "core/frames/tool_turn.hpp"
#include "core/frames/work_frame.hpp"
#include "core/math/angles.hpp"

namespace truepose::config {

void layout(Io& io, ToolFile& x) {
  io("number", x.number, kFrameNumber);
  io("arm", x.arm);
  io.optional("serial", x.serial);
  io("frame", x.X_controller, KukaPose{});
  io("points", x.data.points);
  io("readings", x.data.readings);
}

}  // namespace truepose::config

namespace truepose::record {

void layout(Io& io, FrameReadings& x) {
  io("points", x.points);
  io("readings", x.readings);
}

}  // namespace truepose::record

namespace truepose::config {

void layout(Io& io, BaseFile& x) {
  io("number", x.number, kFrameNumber);
  io("arm", x.arm);
  io("model", x.model, MayBeEmpty{});
  io("frame", x.X, KukaPose{});
  io.optional("covariance", x.covariance, LowerTriangle{6});
  io.optional("touched_by", x.touched_by_mm, Xyz{kMm});
  io("measured", x.data);
}

namespace {

constexpr std::size_t kMostPoints = 100;
const std::vector<std::string> kPointColumns{"x", "y", "z", "point", "px", "py", "pz"};

/// Three columns that are there together or not at all.
class VectorColumns {
 public:
  VectorColumns(const CsvTable& table, const std::string& prefix) : table_(table) {
    const std::array names{prefix + "x", prefix + "y", prefix + "z"};
    if (std::ranges::none_of(names, [&](const std::string& name) { return table.has(name); })) return;
    for (const std::string& name : names) columns_.push_back(table.column(name));
  }
  bool are_there() const { return !columns_.empty(); }
  std::optional<Eigen::Vector3d> at(std::size_t row) const {
    if (columns_.empty()) return std::nullopt;
    return Eigen::Vector3d{table_.number(row, columns_[0]), table_.number(row, columns_[1]),
                           table_.number(row, columns_[2])};
  }

 private:
  const CsvTable& table_;
  std::vector<std::size_t> columns_;
};

/// The point of a row, new or known.
std::size_t point_of(const CsvTable& table, std::size_t row, const VectorColumns& known,
                     std::vector<FramePoint>& points) {
  const std::string name{table.has("point") ? table.text(row, table.column("point")) : kOrigin};
  if (name.empty()) table.fail(row, table.column("point"), "missing, expected the point's name");
  const std::optional<Eigen::Vector3d> p_mm = known.at(row);
  const auto found = std::ranges::find(points, name, &FramePoint::name);
  if (found == points.end()) {
    if (points.size() == kMostPoints) table.fail("more than " + std::to_string(kMostPoints) + " points");
    points.push_back({name, p_mm});
    return points.size() - 1;
  }
  if (found->p_mm != p_mm)
    table.fail(row, table.column("px"), "another row gives " + in_quotes(name) + " other coordinates");
  return static_cast<std::size_t>(found - points.begin());
}

/// What the document says of the named arm.
template <class Record>
Record record_of(const std::string& arm, const std::string& what, const YamlValue& yaml) {
  Record record;
  read_value(yaml, record);
  if (record.arm != arm) yaml.fail("the " + what + " of '" + record.arm + "', but the arm is '" + arm + "'");
  return record;
}

double rounded(double value, double digits) { return std::round(value * digits) / digits; }

/// How far a frame in a file may be from the one that its readings give.
struct FrameLimit {
  double mm, deg;
};

/// One model of an arm against another.
constexpr FrameLimit kOfAnotherModel{2, 0.2};
/// The same model; a noise that was stated otherwise weighs the readings a little differently.
constexpr FrameLimit kOfTheSameModel{0.1, 0.01};

/// Why the frame in a file is not the one that its readings give; empty: it is.
std::string other_frame(const Eigen::Isometry3d& in_file, const Eigen::Isometry3d& by_readings,
                        FrameLimit limit) {
  const double mm = (in_file.translation() - by_readings.translation()).norm();
  const double deg = angle_between(in_file.linear(), by_readings.linear()) * kDegPerRad;
  if (mm <= limit.mm && deg <= limit.deg) return {};
  return formatted(
      "its readings give a frame that is %.3f mm and %.4f deg from the one in it (limit %g mm, %g deg)", mm,
      deg, limit.mm, limit.deg);
}

}  // namespace

std::vector<PlannedPoint> load_points(const std::filesystem::path& file, const TableReading* reading) {
  const CsvTable table = read_table(file, {kPointColumns, {{"point"}}}, reading);
  table.expect_only(kPointColumns);
  const std::size_t name = table.column("point");
  const VectorColumns at(table, ""), known(table, "p");
  std::vector<PlannedPoint> points;
  for (std::size_t row = 0; row < table.row_count(); ++row)
    points.push_back({std::string{table.text(row, name)}, at.at(row), known.at(row)});
  return points;
}

FrameReadings load_frame_readings(const std::filesystem::path& file, const RobotModel& robot, bool of_arm,
                                  const TableReading* table_reading) {
  const std::vector<std::string> joints = joint_column_names("q", robot);
  std::vector<std::string> columns = joints;
  columns.insert(columns.end(), kPointColumns.begin(), kPointColumns.end());
  if (of_arm) columns.insert(columns.end(), kTurnColumns.begin(), kTurnColumns.end());
  // Without joints the tracker read the points.
  std::vector<std::vector<std::string>> needed{joints};
  if (!of_arm) needed.push_back({"x", "y", "z"});
  const CsvTable table = read_table(file, {columns, needed, &robot}, table_reading);
  table.expect_only(columns);
  const VectorColumns seen(table, ""), known(table, "p");
  const TurnColumns turned(table);
  FrameReadings data;
  for (std::size_t row = 0; row < table.row_count(); ++row) {
    FrameReading reading{.point = point_of(table, row, known, data.points),
                         .p_WS_mm = seen.at(row),
                         .orientation = turned.at(row),
                         .row = static_cast<int>(row) + 1};
    if (of_arm || !seen.are_there()) {
      std::vector<double> q;
      for (const std::string& name : joints) q.push_back(table.number(row, table.column(name)));
      reading.q = joints_from(q, robot);
    }
    data.readings.push_back(reading);
  }
  if (data.readings.empty()) table.fail("no readings");
  return data;
}

void write_frame_readings(std::ostream& out, const FrameReadings& data, const RobotModel& robot) {
  const bool seen = data.readings.empty() || data.readings.front().p_WS_mm.has_value();
  const bool known =
      std::ranges::any_of(data.points, [](const FramePoint& point) { return point.p_mm.has_value(); });
  const bool of_arm = data.readings.empty() || data.readings.front().q.size() > 0;
  const bool turned = is_turned(data);
  std::vector<std::string> columns{"point"};
  if (known) columns.insert(columns.end(), {"px", "py", "pz"});
  if (of_arm) std::ranges::copy(joint_column_names("q", robot), std::back_inserter(columns));
  if (seen) columns.insert(columns.end(), {"x", "y", "z"});
  if (turned) columns.insert(columns.end(), kTurnColumns.begin(), kTurnColumns.end());
  for (const std::string& column : columns) out << (&column == &columns.front() ? "" : ",") << column;
  out << '\n';
  for (const FrameReading& reading : data.readings) {
    const FramePoint& point = data.points[reading.point];
    out << csv_field(point.name);
    if (known)
      for (const double mm : point.p_mm.value()) out << ',' << format_number(mm);
    for (Eigen::Index i = 0; i < reading.q.size(); ++i)
      out << ',' << joint_field(reading.q[i], robot.joints[static_cast<std::size_t>(i)]);
    if (seen)
      for (const double mm : *reading.p_WS_mm) out << ',' << format_number(mm);
    if (turned) out << ',' << turn_fields(reading.orientation);
    out << '\n';
  }
}

Eigen::Isometry3d rounded_for_controller(const Eigen::Isometry3d& X) {
  Eigen::Vector3d xyz_mm = X.translation(), abc_deg = kuka_abc_deg(X.linear());
  for (double& mm : xyz_mm) mm = rounded(mm, 1e4);
  for (double& deg : abc_deg) deg = rounded(deg, 1e5);
  return pose_from_kuka(xyz_mm, abc_deg);
}

std::string tool_yaml(const ToolFile& tool) {
  return sealed(
      "# A tool that was measured. frame: what the controller has in TOOL_DATA, mm and deg; readings: mm and "
      "rad, turns of a 6-D target (axes, sigma) in deg.\n" +
      yaml_of(tool));
}

namespace {

/// @param joints  of the arm in each reading; 0: the arm has no part in them
void expect_readings(const FrameReadings& data, int joints, const YamlValue& yaml) {
  const auto unfit = [&](const FrameReading& reading) {
    return reading.point >= data.points.size() ||
           (joints > 0 ? reading.q.size() != joints : !reading.p_WS_mm.has_value());
  };
  if (data.readings.empty() || std::ranges::any_of(data.readings, unfit))
    yaml.fail("readings: expected some, each of one of the points and " +
              (joints > 0 ? "of " + std::to_string(joints) + " joints" : std::string{"seen by the tracker"}));
}

ToolFile tool_in(const std::string& text, const std::string& name, const RobotModel& robot) {
  const YamlValue yaml =
      parse_sealed(text, name, DocumentKind::Tool, "run `truepose tool` on its readings again");
  ToolFile tool = record_of<ToolFile>(robot.name, "tool", yaml);
  expect_readings(tool.data, robot.joint_count(), yaml);
  return tool;
}

}  // namespace

ToolFile load_tool(const std::filesystem::path& file, const RobotModel& robot) {
  return tool_in(read_text_file(file, kMostBytesOfYaml), file.string(), robot);
}

ToolFile parse_tool(const std::string& text, const std::string& name, const RobotModel& robot) {
  return tool_in(text, name, robot);
}

std::string base_yaml(const BaseFile& base) {
  return sealed(
      "# A work frame that was measured. frame: for BASE_DATA, mm and deg; model: when the model was made that "
      "it holds for; covariance: of its origin (mm) and of a small turn (rad) about the robot's axes; "
      "touched_by: where the TCP that touched is on the flange, mm; measured: mm and rad.\n" +
      yaml_of(base));
}

namespace {

/// Of a model that states no noise: readings of all kinds weigh alike.
MeasuringCell measuring_cell_or_plain(const ModelFile& model) {
  return measuring_cell(model).value_or(MeasuringCell{model.cell, {}, {.repeatability_mm = 1}});
}

/// What the base's readings say under its model.
std::expected<MeasuredFrame, std::string> base_under(const MeasuringCell& by, const BaseFile& base) {
  return work_frame(base.data, by, {base.touched_by_mm.value_or(Eigen::Vector3d(0, 0, 0)), nullptr});
}

}  // namespace

BaseFile load_base(const std::filesystem::path& file, const ModelFile& model) {
  const YamlValue yaml = parse_sealed(read_text_file(file, kMostBytesOfYaml), file.string(),
                                      DocumentKind::Base, "run `truepose base` on its readings again");
  BaseFile base = record_of<BaseFile>(model.name, "base", yaml);
  if (base.model != model.created)
    yaml.fail("measured under the model of " + base.model + ", not of " + model.created +
              ": run `truepose base` with this model again");
  expect_readings(base.data, base.touched_by_mm ? model.cell.robot.joint_count() : 0, yaml);
  const auto measured = base_under(measuring_cell_or_plain(model), base);
  if (!measured) yaml.fail(measured.error());
  if (const std::string other = other_frame(base.X, measured->X, kOfTheSameModel); !other.empty())
    yaml.fail(other + "; run `truepose base` again");
  return base;
}

std::optional<MeasuringCell> measuring_cell(const ModelFile& model,
                                            const std::optional<MeasurementNoise>& stated) {
  const auto reference = drift_reference(model, stated);
  if (!reference) return std::nullopt;
  return MeasuringCell{reference->cell, reference->covariance, reference->noise};
}

std::expected<MeasuredFrame, std::string> tool_under(const MeasuringCell& by, const ToolFile& tool) {
  auto measured = tool_frame(tool.data, by, tool.X_controller.linear());
  if (!measured) return measured;
  if (!measured->is_sound())
    return std::unexpected(std::string{measured->doubtful.empty() && !measured->is_contradictory()
                                           ? "its readings have base or tracker elsewhere than this model"
                                           : "its readings contradict each other under this model"} +
                           "; measure the tool again");
  if (const std::string other = other_frame(tool.X_controller, measured->X, kOfAnotherModel); !other.empty())
    return std::unexpected(other + "; measure the tool again");
  return measured;
}

}  // namespace truepose::config
