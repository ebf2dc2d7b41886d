#include "config/cell_setup.hpp"

#include <algorithm>
#include <vector>

#include "core/judge/cramer_rao.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"

namespace truepose::config {
namespace {

// Taken from the reflector's cone, as far as that leaves so much.
constexpr double kPlacementTolerance_rad = 5 * kRadPerDeg;

}  // namespace

CalibratedCell rough_cell(const CellConfig& cell) {
  return {cell.robot.model,
          BasePose::of(cell.tracker.placement),
          {Reflector{cell.reflector.name, cell.reflector.p_FS_mm}}};
}

Scene scene_of(const CellConfig& cell) {
  const double acceptance_rad = cell.reflector.acceptance_deg * kRadPerDeg;
  return {
      .robot = cell.robot.model,
      .body = cell.robot.body,
      .sight = {.X_WB = cell.tracker.placement,
                .p_FS_mm = cell.reflector.p_FS_mm,
                .facing_F = cell.reflector.facing_F,
                .acceptance_rad = std::max(acceptance_rad - kPlacementTolerance_rad, kPlacementTolerance_rad),
                .beam_radius_mm = cell.tracker.beam_radius_mm},
      .surroundings = cell.surroundings,
      .workspace = cell.workspace,
      .limit_margin_rad = cell.campaign.limit_margin_deg * kRadPerDeg,
      .wrist_margin_rad = cell.campaign.wrist_margin_deg * kRadPerDeg};
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
  options.noise = {cell.tracker.noise, cell.robot.repeatability_mm};
  options.deviation = cell.calibration.deviation;
  options.harmonics = cell.calibration.harmonics;
  options.residual = cell.calibration.residual;
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
  return {.singular_below = cell.stream.singular_deg * kRadPerDeg, .approach = approach};
}

Eigen::Vector3d kept_point_mm(const CellConfig& cell, const CalibratedCell& model) {
  if (cell.stream.p_FT_mm) return *cell.stream.p_FT_mm;
  return model.reflectors.empty() ? Eigen::Vector3d(0, 0, 0) : model.reflectors.front().p_FS_mm;
}

}  // namespace truepose::config
