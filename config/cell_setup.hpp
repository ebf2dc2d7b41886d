#pragma once

#include <expected>
#include <optional>
#include <string>

#include "config/cell_config.hpp"
#include "core/calibrate/calibrate_options.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/plan/measurement_plan.hpp"

namespace truepose::config {

/// The cell as its file describes it: the nominal arm, roughly placed, with its reflector.
CalibratedCell rough_cell(const CellConfig& cell);

/// The reflectors of the cell in its order: as they are known by their names, else as the cell file says. One
/// alone is taken as it is known, whatever its name.
std::vector<Reflector> reflectors_of(const CellConfig& cell, const std::vector<Reflector>& known);

/// By what poses of the cell are judged. The cone in which the reflector is seen is narrowed, because the
/// tracker's placement is known roughly only.
Scene scene_of(const CellConfig& cell);

/// How the cell's campaigns plan, `poses` of them.
PlanOptions plan_options(const CellConfig& cell, int poses);

/// How the cell's campaigns identify.
CalibrateOptions calibrate_options(const CellConfig& cell);

/// Why campaign.identify_poses are too few, and what to set. The poses must yield more equations than the
/// arm's geometry, its base and the reflector have identifiable parameters. Nothing if they do.
std::optional<std::string> too_few_poses(const CellConfig& cell);

/// How the cell's targets are compensated: as its stream does.
///
/// @param approach  directions in which the joints will have moved; outlives the options
CompensationOptions compensation_options(const CellConfig& cell, Approach approach = {});

/// By what a stream and its targets correct: the arm, its flange so moved that the controller's tool is where
/// the real one is, and whose position comes first next to the wrist singularity (flange frame, mm).
struct CorrectedArm {
  RobotModel robot;
  Eigen::Vector3d p_F_mm;
};

/// With a measured tool its TCP comes first; without one the cell's own point, or else the model's first
/// reflector. Errors: readings of the tool that the model does not bear out; a model that does not know how
/// the arm bends under a payload.
///
/// @param payload  what the flange carries; null: what it carried when it was measured
/// @param X_FT     of that tool, as the controller has it; none: as the tool file states it
std::expected<CorrectedArm, std::string> corrected_arm(
    const CellConfig& cell, const CalibratedCell& model, const ToolFile* tool,
    const LinkMass* payload = nullptr, const std::optional<Eigen::Isometry3d>& X_FT = std::nullopt);

/// Why the controller's frame of a measured tool is another than the one in the tool file, in one sentence;
/// empty: it is that one, but for the decimals.
std::string other_tool_data(const ToolFile& tool, const Eigen::Isometry3d& X_FT);

/// What the flange carries with the controller's tool of this number in effect, as the cell file says; null
/// where it does not.
const LinkMass* load_of(const CellConfig& cell, std::optional<int> tool);

}  // namespace truepose::config
