#include "daemon/campaign/stored_model.hpp"

#include <algorithm>
#include <optional>

#include "config/cell_setup.hpp"
#include "config/sealed_text.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "daemon/campaign/campaign_result.hpp"
#include "proto/text/digest.hpp"

namespace truepose::daemon {

namespace {

/// Why a model is refused, or nothing.
using WhyNot = std::optional<std::string>;

WhyNot altered_text(const ModelRecord& record) {
  const std::string now = text::sha256_hex(record.yaml);
  if (record.sha256 == now) return std::nullopt;
  return formatted("its text is not the one that was stored (SHA-256 %.12s..., stored was %.12s...)",
                   now.c_str(), record.sha256.c_str());
}

/// Those of reflectors that the model knows: by another one, which no pose to identify from had shown, it was
/// not validated.
std::vector<config::ValidationPoint> validation_points(const CalibratedCell& cell,
                                                       std::span<const StoredPoint> points) {
  std::vector<config::ValidationPoint> found;
  for (const StoredPoint& point : points) {
    if (point.purpose != PointPurpose::Validate) continue;
    const auto smr = std::ranges::find(cell.reflectors, point.smr, &Reflector::name);
    if (smr == cell.reflectors.end()) continue;
    const auto index = static_cast<int>(smr - cell.reflectors.begin());
    found.push_back({point.q_actual, index, point.direction, {}, *point.p_WS_mm});
  }
  return found;
}

/// Whether the points may have been corrected by nests and two-face measurements.
bool may_be_corrected(std::span<const StoredPoint> points) {
  return std::ranges::any_of(points, [](const StoredPoint& point) { return !is_pose(point.purpose); });
}

/// The store keeps points as they were measured. Where they were corrected, the model has them.
WhyNot other_error(const ModelRecord& record, const config::ModelFile& model,
                   std::span<const StoredPoint> points) {
  const CalibratedCell& cell = model.cell;
  const auto validation = may_be_corrected(points) ? model.validation : validation_points(cell, points);
  return config::other_error(cell, validation, record.validation_after_mm);
}

bool same_joints(const RobotModel& nominal, const RobotModel& calibrated,
                 std::span<const StoredPoint> points) {
  const int joints = nominal.joint_count();
  return calibrated.joint_count() == joints &&
         std::ranges::all_of(points, [joints](const StoredPoint& point) {
           return point.q_target.size() == joints && point.q_actual.size() == joints;
         });
}

/// Which pose limits that were narrowed meanwhile exclude.
WhyNot outside_limits(const RobotModel& nominal, std::span<const StoredPoint> points) {
  for (const StoredPoint& point : points) {
    if (!shows_arm(point)) continue;
    for (int i = 0; i < nominal.joint_count(); ++i) {
      const Joint& joint = nominal.joints[static_cast<std::size_t>(i)];
      if (point.q_target[i] >= joint.min && point.q_target[i] <= joint.max) continue;
      return formatted(
          "pose %d, which it was made from, lies outside the limits of the robot file: joint %d at %.3f deg, its "
          "limits are %g..%g deg",
          point.pose, i + 1, point.q_target[i] / kRadPerDeg, joint.min / kRadPerDeg, joint.max / kRadPerDeg);
    }
  }
  return std::nullopt;
}

std::string not_checked(const ModelRecord& record, std::span<const StoredPoint> points) {
  if (!points.empty()) return {};
  return "model " + record.id +
         ": the points of its campaign are not in this store: its error and its corrections were not computed "
         "again";
}

std::unexpected<std::string> model_refused(const ModelRecord& record, const std::string& why,
                                           const char* advice = "activate another model, or identify again") {
  return std::unexpected("model " + record.id + " is refused: " + why + "; " + advice);
}

}  // namespace

std::vector<JointVector> poses_of_task(std::span<const StoredPoint> points) {
  std::vector<JointVector> poses;
  for (const StoredPoint& point : points)
    if (shows_arm(point)) poses.push_back(point.q_target);
  return poses;
}

std::expected<config::ModelFile, std::string> unaltered_model(const ModelRecord& record) {
  if (const WhyNot altered = altered_text(record)) return model_refused(record, *altered);
  if (!config::has_its_seal(record.yaml))
    return model_refused(record, "its text is not the one that was made (its last line has another SHA-256)");
  try {
    return config::parse_model(record.yaml, "its text");
  } catch (const config::ConfigError& error) {
    return model_refused(record, error.what());
  }
}

std::expected<StoredModel, std::string> checked_model(const ModelRecord& record,
                                                      std::span<const StoredPoint> points,
                                                      const config::CellConfig& config) {
  const auto refused = [&record](const std::string& why) { return model_refused(record, why); };
  auto file = unaltered_model(record);
  if (!file) return std::unexpected(file.error());
  StoredModel model{*std::move(file), not_checked(record, points)};
  if (!same_joints(config.robot.model, model.file.cell.robot, points))
    return refused("it, or a point that it was made from, has other joints than " + config.robot.model.name);
  if (model.file.serial != record.robot_serial)
    return refused("its text is of arm " + model.file.serial + ", its row of arm " + record.robot_serial);
  if (const WhyNot other = config::other_nominal(config.robot.model, model.file)) return refused(*other);
  if (const WhyNot other = other_error(record, model.file, points)) return refused(*other);
  if (const WhyNot larger = config::larger_correction(config.robot.model, model.file.cell,
                                                      poses_of_task(points), record.largest_correction_deg)) {
    // Then what it corrects there cannot be computed.
    if (const WhyNot outside = outside_limits(config.robot.model, points))
      return model_refused(record, *outside, "widen them, activate another model, or measure again");
    return refused(*larger);
  }
  return model;
}

CalibratedCell known_cell(const config::CellConfig& config, const CalibratedCell& model) {
  return {config.robot.model, model.base, model.reflectors};
}

TargetCompensation::Result compensated(const JointVector& q, const std::vector<std::int8_t>& directions,
                                       const config::CellConfig& config, const CalibratedCell& model) {
  const TargetCompensation compensation{config.robot.model, model.robot,
                                        config::compensation_options(config, directions)};
  return compensation.at_joints(q, model.reflectors.front().p_FS_mm);
}

Scene known_scene(const config::CellConfig& config, const CalibratedCell& model) {
  Scene scene = config::scene_of(config);
  scene.sight.X_WB = model.base.isometry();
  scene.sight.p_FS_mm = model.reflectors.front().p_FS_mm;
  scene.sight.acceptance_rad = config.reflector.acceptance_deg * kRadPerDeg;
  scene.sight.further.clear();
  scene.limit_margin_rad = scene.limit_margin_mm = scene.wrist_margin_rad = 0;
  return scene;
}

}  // namespace truepose::daemon
