#include "daemon/campaign/tool_cell.hpp"

namespace truepose::daemon {

namespace {

/// What a tool occupies of which its TCP alone is known: a rod from the flange up to shortly before it, where
/// the reflector sits. Nothing of one that is too short for that, or of an arm whose body is not known.
void add_rod(const Eigen::Vector3d& reach_F_mm, config::RobotConfig& robot) {
  constexpr double kRadius_mm = 25, kBeforeReflector_mm = 60;
  const double length_mm = reach_F_mm.norm() - kBeforeReflector_mm;
  if (robot.body.empty() || length_mm <= kRadius_mm) return;
  robot.body.push_back(
      {robot.model.joint_count() + 1, {{0, 0, 0}, reach_F_mm.normalized() * length_mm, kRadius_mm}});
}

}  // namespace

config::CellConfig cell_with_tool(config::CellConfig cell, const ToolOrder& order) {
  cell.tracker.robot_base = order.by.cell.base.isometry();
  config::ReflectorConfig reflector = cell.reflector;
  reflector.facing_F = order.facing_F.value_or(reflector.facing_F);
  if (order.reach_F_mm) add_rod(*order.reach_F_mm, cell.robot);
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

}  // namespace truepose::daemon
