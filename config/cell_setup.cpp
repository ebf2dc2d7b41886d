#include "config/cell_setup.hpp"

#include <algorithm>
#include <vector>

#include "core/arm/payload.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"
#include "core/quality/cramer_rao.hpp"

namespace truepose::config {
namespace {

// Taken from the reflector's cone, as far as that leaves so much.
constexpr double kPlacementTolerance_rad = 5 * kRadPerDeg;

/// Of a tool with one point and no 6-D target it is the controller's own.
bool has_orientation(const ToolFile& tool) {
  const auto has_axes = [](const FrameReading& reading) { return reading.orientation.has_value(); };
  return tool.data.points.size() > 1 || std::ranges::any_of(tool.data.readings, has_axes);
}

}  // namespace

CalibratedCell rough_cell(const CellConfig& cell) {
  CalibratedCell rough{cell.robot.model, BasePose::of(cell.tracker.robot_base), {}};
  for (const ReflectorConfig& reflector : reflectors_of(cell))
    rough.reflectors.push_back({reflector.name, reflector.p_FS_mm});
  return rough;
}

std::vector<Reflector> reflectors_of(const CellConfig& cell, const std::vector<Reflector>& known) {
  if (cell.further_reflectors.empty()) return known;
  std::vector<Reflector> all;
  for (const ReflectorConfig& reflector : reflectors_of(cell)) {
    const auto found = std::ranges::find(known, reflector.name, &Reflector::name);
    all.push_back(found == known.end() ? Reflector{reflector.name, reflector.p_FS_mm} : *found);
  }
  return all;
}

Scene scene_of(const CellConfig& cell) {
  const auto planned_rad = [](const ReflectorConfig& reflector) {
    const double acceptance_rad = reflector.acceptance_deg * kRadPerDeg;
    return std::max(acceptance_rad - kPlacementTolerance_rad, kPlacementTolerance_rad);
  };
  std::vector<SightedReflector> further;
  for (const ReflectorConfig& reflector : cell.further_reflectors)
    further.push_back({reflector.p_FS_mm, reflector.facing_F, planned_rad(reflector)});
  return {.robot = cell.robot.model,
          .body = cell.robot.body,
          .sight = {.X_WB = cell.tracker.robot_base,
                    .p_FS_mm = cell.reflector.p_FS_mm,
                    .facing_F = cell.reflector.facing_F,
                    .acceptance_rad = planned_rad(cell.reflector),
                    .beam_radius_mm = cell.tracker.beam_radius_mm,
                    .further = further},
          .surroundings = cell.surroundings,
          .workspace = cell.workspace,
          .limit_margin_rad = cell.campaign.limit_margin_deg * kRadPerDeg,
          .wrist_margin_rad = cell.campaign.singularity_margin_deg * kRadPerDeg};
}

PlanOptions plan_options(const CellConfig& cell, int poses) {
  PlanOptions options;
  options.poses = poses;
  options.candidates = cell.campaign.candidates;
  options.seed = cell.campaign.seed;
  options.criterion = cell.campaign.criterion;
  options.task = cell.task;
  options.noise = {cell.tracker.noise, cell.robot.repeatability_mm};
  options.start = JointVector::Zero(cell.robot.model.joint_count());
  options.reference_every = cell.campaign.reference_every;
  return options;
}

CalibrateOptions calibrate_options(const CellConfig& cell) {
  CalibrateOptions options;
  options.loss = cell.calibration.loss;
  options.prior = cell.calibration.prior;
  options.noise = {cell.tracker.noise, cell.robot.repeatability_mm};
  options.non_geometric = cell.calibration.non_geometric;
  options.harmonics = cell.calibration.harmonics;
  options.field = cell.calibration.field;
  return options;
}

std::optional<std::string> too_few_poses(const CellConfig& cell) {
  constexpr int kPoses = 60;  // more than any arm of eight joints needs
  const CalibratedCell nominal = rough_cell(cell);
  Random random(0);
  std::vector<JointVector> poses;
  for (int i = 0; i < kPoses; ++i) {
    JointVector& q = poses.emplace_back(nominal.robot.joint_count());
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const Joint& joint = nominal.robot.joints[static_cast<std::size_t>(j)];
      q[j] = random.uniform(joint.min, joint.max);
    }
  }
  const auto parameters = static_cast<int>(whitened_basis(position_jacobian(nominal, poses)).cols());
  const int fewest = parameters / 3 + 1;
  if (cell.campaign.identify_poses >= fewest) return std::nullopt;
  return std::to_string(cell.campaign.identify_poses) +
         " are too few for the parameters of this arm: give at least " + std::to_string(fewest) +
         ", better twice as many";
}

CompensationOptions compensation_options(const CellConfig& cell, Approach approach) {
  return {.singular_below = cell.stream.singularity_threshold_deg * kRadPerDeg, .approach = approach};
}

std::expected<CorrectedArm, std::string> corrected_arm(const CellConfig& cell, const CalibratedCell& model,
                                                       const ToolFile* tool, const LinkMass* payload,
                                                       const std::optional<Eigen::Isometry3d>& X_FT) {
  if (payload) {
    auto arm = carrying(model.robot, *payload);
    if (!arm) return std::unexpected("payload: " + arm.error());
    CalibratedCell loaded = model;
    loaded.robot = *std::move(arm);
    return corrected_arm(cell, loaded, tool, nullptr, X_FT);
  }
  if (!tool) {
    const Eigen::Vector3d p_FS_mm =
        model.reflectors.empty() ? Eigen::Vector3d(0, 0, 0) : model.reflectors.front().p_FS_mm;
    return CorrectedArm{model.robot, cell.stream.p_FT_mm.value_or(p_FS_mm)};
  }
  ToolFile by_controller = *tool;
  if (X_FT && !has_orientation(*tool)) by_controller.X_controller.linear() = X_FT->linear();
  const auto measured =
      tool_under({model, {}, {cell.tracker.noise, cell.robot.repeatability_mm}}, by_controller);
  if (!measured) return std::unexpected("tool " + std::to_string(tool->number) + ": " + measured.error());
  const Eigen::Isometry3d& X_controller = X_FT ? *X_FT : tool->X_controller;
  return CorrectedArm{with_tool(model.robot, measured->X, X_controller), X_controller.translation()};
}

std::string other_tool_data(const ToolFile& tool, const Eigen::Isometry3d& X_FT) {
  constexpr double kMost_mm = 0.02, kMost_deg = 0.002;  // of a REAL, typed with three decimals
  const double mm = (X_FT.translation() - tool.X_controller.translation()).norm();
  const bool abc = has_orientation(tool);
  const double deg = abc ? angle_between(X_FT.linear(), tool.X_controller.linear()) * kDegPerRad : 0;
  if (mm <= kMost_mm && deg <= kMost_deg) return {};
  const std::string number = std::to_string(tool.number);
  return "the controller's frame of tool " + number + formatted(" is %.3f mm", mm) +
         (abc ? formatted(" and %.4f deg", deg) : "") +
         " from the measured one, and is corrected as the controller has it: put the measured " +
         (abc ? "frame" : "X, Y, Z") + " into TOOL_DATA[" + number +
         "] (truepose tools list), or work without the measured tool";
}

const LinkMass* load_of(const CellConfig& cell, std::optional<int> tool) {
  const auto found = std::ranges::find(cell.loads, tool.value_or(0), &ToolLoad::tool);
  return found == cell.loads.end() ? nullptr : &found->payload;
}

}  // namespace truepose::config
