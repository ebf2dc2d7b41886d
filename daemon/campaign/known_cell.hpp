#pragma once

#include "config/cell_config.hpp"
#include "core/identify/calibrated_cell.hpp"
#include "core/plan/scene.hpp"

namespace truepose::daemon {

/// The nominal arm where an active model says that the base and the reflector are: what targets refer to.
CalibratedCell known_cell(const config::CellConfig& config, const CalibratedCell& model);

/// What poses that a user asks for are judged by: the placement is known, and no margins are kept.
Scene known_scene(const config::CellConfig& config, const CalibratedCell& model);

}  // namespace truepose::daemon
