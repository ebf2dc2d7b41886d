#include "daemon/campaign/tool_cell.hpp"

#include <algorithm>
#include <utility>

namespace truepose::daemon {

config::CellConfig cell_with_tool(config::CellConfig cell, const ToolOrder& order) {
  cell.tracker.placement = order.by.cell.base.isometry();
  config::ReflectorConfig reflector = cell.reflector;
  reflector.facing_F = order.facing_F.value_or(reflector.facing_F);
  cell.further_reflectors.clear();
  for (const ToolPoint& point : order.points) {
    reflector.name = point.point.name;
    reflector.p_FS_mm = point.p_F_mm;
    cell.further_reflectors.push_back(reflector);
  }
  cell.reflector = cell.further_reflectors.front();
  cell.further_reflectors.erase(cell.further_reflectors.begin());
  return cell;
}

std::string why_no_frame(const ToolOrder& order) {
  // Any coordinates do where the points' names alone have to tell it.
  std::vector<FramePoint> points;
  std::vector<Eigen::Vector3d> p_mm;
  for (const ToolPoint& each : order.points) {
    points.push_back(each.point);
    const std::string& name = each.point.name;
    p_mm.push_back(
        each.point.p_mm.value_or(Eigen::Vector3d(name == kOnX ? 100 : 0, name == kInXy ? 100 : 0, 0)));
  }
  const auto frame = frame_of_points(points, p_mm, order.R_else);
  return frame ? "" : frame.error();
}

}  // namespace truepose::daemon
