#include "daemon/campaign/identification.hpp"

#include <algorithm>
#include <set>

#include "config/cell_setup.hpp"
#include "core/formatted.hpp"
#include "core/quality/model_noise.hpp"
#include "daemon/campaign/corrected_points.hpp"
#include "daemon/campaign/stored_model.hpp"

namespace truepose::daemon {

namespace {

/// Where the reference pose was seen.
std::vector<Eigen::Vector3d> references_mm(const std::vector<StoredPoint>& points) {
  std::vector<Eigen::Vector3d> references_mm;
  for (const StoredPoint& point : points)
    if (point.purpose == PointPurpose::Reference) references_mm.push_back(*point.p_WS_mm);
  return references_mm;
}

/// Near a singularity a correction is shortened where it would make the orientation worse than without it.
std::optional<Finding> corrected_in_part(const CalibrationResult& result,
                                         const std::vector<StoredPoint>& points,
                                         const config::CellConfig& config) {
  if (!result.calibration.validate) return std::nullopt;
  const CalibratedCell& cell = result.calibration.cell;
  const CalibratedCell asked = known_cell(config, cell);
  std::string poses;
  for (const auto& [point, error_mm] : result.remeasured_points) {
    const auto smr = std::ranges::find(cell.reflectors, point.smr, &Reflector::name);
    if (smr == cell.reflectors.end()) continue;
    const auto index = static_cast<int>(smr - cell.reflectors.begin());
    const double left_mm =
        (cell.predict(point.q_commanded, index, point.direction) - asked.predict(point.q_target, index))
            .norm();
    const StoredPoint* const before = validation_of(point, points);
    if (before == nullptr || left_mm <= result.calibration.validate->after.max) continue;
    poses += (poses.empty() ? "" : ", ") + formatted("pose %d (%.2f mm)", before->pose, left_mm);
  }
  if (poses.empty()) return std::nullopt;
  return finding(
      FindingKind::CorrectedInPart,
      "a whole correction near a singularity would make the orientation worse: by the model these stay off: " +
          poses);
}

}  // namespace

std::expected<CalibrationResult, std::string> identified(const std::vector<StoredPoint>& points,
                                                         const config::CellConfig& config,
                                                         const std::vector<Resumption>& resumptions) {
  const MeasurementData data = campaign_data(points, config, resumptions);
  const CalibrateOptions options = config::calibrate_options(config);
  auto calibrated = calibrate(config.robot.model, data, options);
  if (!calibrated) return std::unexpected(calibrated.error().detail);
  if (!calibrated->converged) return std::unexpected("the identification did not converge");
  CalibrationResult result;
  result.calibration = *std::move(calibrated);
  const MeasurementData fitted = as_fitted(result.calibration, data);
  result.noise = noise_about_model(result.calibration, fitted, options.noise);
  result.validation_distances2 = validation_distances2(result.calibration, fitted, result.noise);
  // Drift of the tracker, the base or the arm.
  const auto references = references_mm(corrected_points(points, config, resumptions).points);
  for (const Eigen::Vector3d& p_mm : references)
    result.reference_drift_mm.push_back((p_mm - references.front()).norm());
  result.verdict = verdict_on(result, points, config, resumptions);
  return result;
}

CalibrationVerdict verdict_on(const CalibrationResult& result, const std::vector<StoredPoint>& points,
                              const config::CellConfig& config, const std::vector<Resumption>& resumptions) {
  const CorrectedPoints corrected = corrected_points(points, config, resumptions);
  const MeasurementData data = as_fitted(result.calibration, campaign_data(points, config, resumptions));
  std::vector<Finding> findings = corrected.findings;
  if (auto in_part = corrected_in_part(result, corrected.points, config))
    findings.push_back(*std::move(in_part));
  return calibration_verdict({.calibration = result.calibration,
                              .data = data,
                              .stated = config::calibrate_options(config).noise,
                              .reference_mm = references_mm(corrected.points),
                              .remeasured = result.remeasured,
                              .task_stated = config.task.is_bounded(),
                              .further_findings = findings});
}

std::vector<int> drawn_to_validate(const std::vector<StoredPoint>& points, double share, std::uint64_t seed) {
  MeasurementData data = measurement_data(points, {});
  split_poses(data, share, seed);
  std::set<int> poses;
  for (const Measurement& point : data.points)
    if (point.set == PoseSet::Validate) poses.insert(point.pose);
  return {poses.begin(), poses.end()};
}

int count_poses(const std::vector<StoredPoint>& points, PointPurpose purpose) {
  std::set<int> poses;
  for (const StoredPoint& point : points)
    if (point.purpose == purpose) poses.insert(point.pose);
  return static_cast<int>(poses.size());
}

}  // namespace truepose::daemon
