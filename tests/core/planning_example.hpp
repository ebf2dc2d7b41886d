#pragma once

#include "config/robot_file.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/math/angles.hpp"
#include "core/plan/scene.hpp"

namespace truepose::test {

/// The example cell's scene: a KR 210 with its body, the tracker 3.6 m away, a small tool, a table.
inline Scene planning_scene() {
  const char* file = TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml";
  Scene scene{.robot = config::load_robot(file), .body = config::load_body(file)};
  scene.body.push_back({7, {{0, 0, 0}, {0, 0, 120}, 60}});
  scene.sight = {.X_WB = pose_from_kuka({3420, 430, -1230}, {166, 0, 0}),
                 .p_FS_mm = {60, -50, 190},
                 .facing_F = {0.56, -0.43, 0.71},
                 .acceptance_rad = 30 * kRadPerDeg};
  scene.surroundings.obstacles = {{{1200, 900, 0}, {1900, 900, 0}, 500}};
  scene.limit_margin_rad = 5 * kRadPerDeg;
  scene.wrist_margin_rad = 3 * kRadPerDeg;
  return scene;
}

inline CalibratedCell planning_cell() {
  const Scene scene = planning_scene();
  return {scene.robot, BasePose::of(scene.sight.X_WB), {{"1", scene.sight.p_FS_mm}}};
}

}  // namespace truepose::test
