#include "daemon/cell/frame_order.hpp"

#include <algorithm>
#include <utility>

#include "core/formatted.hpp"
#include "core/math/angles.hpp"

namespace truepose::daemon {

namespace {

using Row = std::vector<double>;

constexpr std::size_t kMostFixturePoints = 50;

Eigen::Vector3d vector_of(const Row& row) { return {row[0], row[1], row[2]}; }

/// Where a tool is taken to be before it is measured.
struct Assumed {
  Eigen::Vector3d p_F_mm;
  std::string by_what;
  bool is_tcp = true;  ///< else it is but a place to begin at
};

Assumed assumed_tcp(int number, const config::CellConfig& config, const ToolService& tools) {
  if (const config::ToolFile* known = tools.of(number))
    return {known->X_controller.translation(), "where the TCP was measured before"};
  if (config.stream.p_FT_mm) return {*config.stream.p_FT_mm, "where stream.tcp of the cell file has it"};
  return {config.reflector.p_FS_mm, "where the cell file has its reflector, as the TCP is not known", false};
}

/// A row of a list that has one for each point.
const Row* row_of(const std::optional<std::vector<Row>>& rows, std::size_t point) {
  return rows && point < rows->size() ? &(*rows)[point] : nullptr;
}

/// The tool of this number, to touch with. None if it was not measured, which is reported to `read`.
std::optional<TouchOrder> touch_order(int number, control::ParamReader& read, const ToolService& tools) {
  if (const std::string refused = tools.refusal(number); !refused.empty()) {
    read.fail("touch", refused);
    return std::nullopt;
  }
  if (const config::ToolFile* known = tools.of(number)) return TouchOrder{*known, {}};
  const std::string tool = std::to_string(number);
  read.fail("touch", "no tool " + tool + " is in use: measure it (truepose campaign start --tool " + tool +
                         "), then take it into use (truepose tools activate ID)");
  return std::nullopt;
}

std::vector<FramePoint> framed(const std::vector<ToolPoint>& points) {
  std::vector<FramePoint> framed;
  for (const ToolPoint& point : points) framed.push_back(point.point);
  return framed;
}

/// Why points of these names and coordinates tell no frame; empty: they do.
/// @param R_else  of a frame of which the origin alone is measured; none: that does not do
std::string why_no_frame(const std::vector<FramePoint>& points,
                         const std::optional<Eigen::Matrix3d>& R_else) {
  // Any coordinates do where the points' names alone have to tell it.
  std::vector<Eigen::Vector3d> p_mm;
  for (const FramePoint& point : points)
    p_mm.push_back(
        point.p_mm.value_or(Eigen::Vector3d(point.name == kOnX ? 100 : 0, point.name == kInXy ? 100 : 0, 0)));
  const auto frame = frame_of_points(points, p_mm, R_else);
  return frame ? "" : frame.error();
}

}  // namespace

ToolOrder tool_order(control::ParamReader& read, const config::CellConfig& config, const ToolService& tools) {
  ToolOrder order;
  order.number = static_cast<int>(read.required(read.integer("number", 1, 1000), "number"));
  const auto names = read.texts("points").value_or(std::vector<std::string>{kOrigin});
  const auto at = read.rows("at", 3, config::kMostReflectors);
  const auto known = read.rows("nominal", 3, config::kMostReflectors);
  const auto facing = read.rows("facing", 3, 1), orientation = read.rows("orientation", 3, 1);
  order.together = read.boolean("together").value_or(false);
  order.poses = static_cast<int>(read.integer("poses_per_point", 1, 100).value_or(order.poses));
  if (names.empty() || names.size() > config::kMostReflectors)
    read.fail("points", "expected 1 to " + std::to_string(config::kMostReflectors));
  if (at && at->size() != names.size()) read.fail("at", "expected a row for each of the points");
  if (known && known->size() != names.size()) read.fail("nominal", "expected a row for each of the points");
  if (order.together && names.size() > 1 && !at)
    read.fail("at", "missing: reflectors that are seen together are identified by where they are");

  const Assumed assumed = assumed_tcp(order.number, config, tools);
  if (assumed.is_tcp) order.reach_F_mm = assumed.p_F_mm;
  order.points.clear();
  for (std::size_t i = 0; i < names.size(); ++i) {
    ToolPoint& point = order.points.emplace_back(ToolPoint{{names[i], std::nullopt}, assumed.p_F_mm});
    if (const Row* row = row_of(known, i)) point.point.p_mm = vector_of(*row);
    if (const Row* row = row_of(at, i)) point.p_F_mm = vector_of(*row);
  }
  if (!at)
    order.assumed = formatted(
        "tool %d: the reflector is looked for within %.0f mm of (%.0f %.0f %.0f) mm in the "
        "flange, %s",
        order.number, config.tracker.first_search_radius_mm, assumed.p_F_mm.x(), assumed.p_F_mm.y(),
        assumed.p_F_mm.z(), assumed.by_what.c_str());
  if (facing && vector_of(facing->front()).norm() < 1e-6) read.fail("facing", "a direction of no length");
  if (facing) order.facing_F = vector_of(facing->front()).normalized();
  if (orientation) order.R_given = pose_from_kuka({0, 0, 0}, vector_of(orientation->front())).linear();
  const Eigen::Matrix3d flange = Eigen::Matrix3d::Identity();
  if (!order.points.empty())
    if (const std::string why = why_no_frame(framed(order.points), order.R_given.value_or(flange));
        !why.empty())
      read.fail("points", why);
  return order;
}

BaseOrder base_order(control::ParamReader& read, const ToolService& tools) {
  BaseOrder order;
  order.number = static_cast<int>(read.required(read.integer("number", 1, 1000), "number"));
  const auto names = read.required(read.texts("points"), "points");
  const auto at = read.rows("at", 3, kMostFixturePoints);
  const auto known = read.rows("nominal", 3, kMostFixturePoints);
  const auto touching = read.integer("touch", 1, 1000);
  const bool touched = touching.has_value();
  if (touched) order.touch = touch_order(static_cast<int>(*touching), read, tools);
  order.readings = static_cast<int>(read.integer("readings", 1, 100).value_or(touched ? 1 : order.readings));
  if (names.size() > kMostFixturePoints)
    read.fail("points", "expected at most " + std::to_string(kMostFixturePoints));
  if (!at && !touched)
    read.fail("at",
              "missing: the tracker needs the rough position of each point; or give touch, the number of "
              "the tool that touches them with its TCP");
  if (at && touched)
    read.fail("at", "the tracker looks for no points that touch asks for: leave out one of both");
  if (at && at->size() != names.size()) read.fail("at", "expected a row for each of the points");
  if (known && known->size() != names.size()) read.fail("nominal", "expected a row for each of the points");
  std::vector<FramePoint> points;
  for (std::size_t i = 0; i < names.size(); ++i) {
    FixturePoint& point = order.points.emplace_back(FixturePoint{{names[i], std::nullopt}});
    if (const Row* row = row_of(at, i)) point.p_B_mm = vector_of(*row);
    if (const Row* row = row_of(known, i)) point.point.p_mm = vector_of(*row);
    points.push_back(point.point);
  }
  if (const std::string why = why_no_frame(points, std::nullopt); !why.empty()) read.fail("points", why);
  return order;
}

std::expected<void, std::string> use_model(MeasuringCell by, const ModelRecord& model, BaseOrder& order) {
  if (order.touch) {
    auto measured = config::tool_under(by, order.touch->tool);
    if (!measured)
      return std::unexpected("tool " + std::to_string(order.touch->tool.number) + ": " + measured.error());
    order.touch->measured = *std::move(measured);
  }
  order.by = std::move(by);
  order.model_id = model.id;
  order.model_made = model.created;
  return {};
}

}  // namespace truepose::daemon
