#include "daemon/cell/frame_order.hpp"

#include <algorithm>
#include <utility>

#include "core/formatted.hpp"
#include "core/math/angles.hpp"

namespace truepose::daemon {

using control::RpcError;

namespace {

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

/// The row of a point in a list that has one for each, or none at all.
std::optional<Eigen::Vector3d> row_of(const std::vector<Eigen::Vector3d>& rows, std::size_t point) {
  return rows.empty() ? std::nullopt : std::optional{rows[point]};
}

/// The tool of this number, to touch with. Error: it was not measured.
std::expected<TouchOrder, RpcError> touch_order(int number, const ToolService& tools) {
  if (const std::string refused = tools.refusal(number); !refused.empty())
    return rpc::refused("touch", refused);
  if (const config::ToolFile* known = tools.of(number)) return TouchOrder{*known, {}};
  const std::string tool = std::to_string(number);
  return rpc::refused("touch", "no tool " + tool + " is in use: measure it (truepose campaign start --tool " +
                                   tool + "), then take it into use (truepose tools activate ID)");
}

std::vector<FramePoint> framed(const auto& points) {
  std::vector<FramePoint> framed;
  for (const auto& point : points) framed.push_back(point.point);
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

std::expected<ToolOrder, RpcError> tool_order(const rpc::CampaignStart& asked,
                                              const config::CellConfig& config, const ToolService& tools) {
  ToolOrder order;
  order.number = asked.number.value();
  order.together = asked.together;
  order.poses = *asked.poses_per_point;
  const std::vector<std::string> names =
      asked.points.empty() ? std::vector<std::string>{kOrigin} : asked.points;
  if (names.size() > config::kMostReflectors)
    return rpc::refused("points", "expected 1 to " + std::to_string(config::kMostReflectors));
  if (order.together && names.size() > 1 && asked.at.empty())
    return rpc::refused("at", "missing: reflectors that are seen together are identified by where they are");

  const Assumed assumed = assumed_tcp(order.number, config, tools);
  if (assumed.is_tcp) order.reach_F_mm = assumed.p_F_mm;
  order.points.clear();
  for (std::size_t i = 0; i < names.size(); ++i)
    order.points.push_back(
        {{names[i], row_of(asked.nominal, i)}, row_of(asked.at, i).value_or(assumed.p_F_mm)});
  if (asked.at.empty())
    order.assumed = formatted(
        "tool %d: the reflector is looked for within %.0f mm of (%.0f %.0f %.0f) mm in the "
        "flange, %s",
        order.number, config.tracker.first_search_radius_mm, assumed.p_F_mm.x(), assumed.p_F_mm.y(),
        assumed.p_F_mm.z(), assumed.by_what.c_str());
  if (!asked.facing.empty()) order.facing_F = asked.facing.front().normalized();
  if (!asked.orientation.empty())
    order.R_given = pose_from_kuka({0, 0, 0}, asked.orientation.front()).linear();
  const Eigen::Matrix3d flange = Eigen::Matrix3d::Identity();
  if (const std::string why = why_no_frame(framed(order.points), order.R_given.value_or(flange));
      !why.empty())
    return rpc::refused("points", why);
  return order;
}

std::expected<BaseOrder, RpcError> base_order(const rpc::CampaignStart& asked, const ToolService& tools) {
  BaseOrder order;
  order.number = asked.number.value();
  if (asked.touch) {
    auto touch = touch_order(*asked.touch, tools);
    if (!touch) return std::unexpected(touch.error());
    order.touch = *std::move(touch);
  } else if (asked.at.empty()) {
    return rpc::refused(
        "at",
        "missing: the tracker needs the rough position of each point; or give touch, the number of "
        "the tool that touches them with its TCP");
  }
  order.readings = asked.readings.value_or(asked.touch ? 1 : order.readings);
  const Eigen::Vector3d unknown{0, 0, 0};
  for (std::size_t i = 0; i < asked.points.size(); ++i)
    order.points.push_back(
        {{asked.points[i], row_of(asked.nominal, i)}, row_of(asked.at, i).value_or(unknown)});
  if (const std::string why = why_no_frame(framed(order.points), std::nullopt); !why.empty())
    return rpc::refused("points", why);
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
  order.model_serial = model.robot_serial;
  order.model_made = model.created;
  return {};
}

}  // namespace truepose::daemon
