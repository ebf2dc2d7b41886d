#include "daemon/campaign/known_cell.hpp"

#include "config/cell_setup.hpp"
#include "core/math/angles.hpp"

namespace truepose::daemon {

CalibratedCell known_cell(const config::CellConfig& config, const CalibratedCell& model) {
  return {config.robot.model, model.base, model.reflectors};
}

Scene known_scene(const config::CellConfig& config, const CalibratedCell& model) {
  Scene scene = config::scene_of(config);
  scene.sight.X_WB = model.base.isometry();
  scene.sight.p_FS_mm = model.reflectors.front().p_FS_mm;
  scene.sight.acceptance_rad = config.reflector.acceptance_deg * kRadPerDeg;
  scene.limit_margin_rad = scene.limit_margin_mm = scene.wrist_margin_rad = 0;
  return scene;
}

}  // namespace truepose::daemon
