#pragma once

#include <optional>
#include <string>

#include "config/cell_config.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/identify/calibrate.hpp"
#include "core/plan/measurement_plan.hpp"

namespace truepose::config {

/// The cell as its file describes it: the nominal arm, roughly placed, with its reflector.
CalibratedCell rough_cell(const CellConfig& cell);

/// By what poses of the cell are judged. The cone in which the reflector is seen is narrowed, because the
/// tracker's placement is known roughly only.
Scene scene_of(const CellConfig& cell);

/// How the cell's campaigns plan, `poses` of them.
PlanOptions plan_options(const CellConfig& cell, int poses);

/// How the cell's campaigns identify.
CalibrateOptions calibrate_options(const CellConfig& cell);

/// Why campaign.identify_poses are too few, and what to give: they must yield more equations than the arm's
/// geometry, its base and the reflector have parameters that can be told apart. Nothing where they do.
std::optional<std::string> too_few_poses(const CellConfig& cell);

/// How the cell's targets are compensated: as its stream does.
///
/// @param approach  directions in which the joints will have moved; outlives the options
CompensationOptions compensation_options(const CellConfig& cell, Approach approach = {});

/// Whose position the stream and its targets keep next to the wrist singularity: the cell's TCP, or else the
/// model's first reflector. Flange frame, mm.
Eigen::Vector3d kept_point_mm(const CellConfig& cell, const CalibratedCell& model);

}  // namespace truepose::config
