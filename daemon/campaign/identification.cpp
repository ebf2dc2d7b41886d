#include "daemon/campaign/identification.hpp"

#include <algorithm>
#include <set>

#include "config/cell_setup.hpp"
#include "core/quality/model_noise.hpp"
#include "daemon/campaign/corrected_points.hpp"

namespace truepose::daemon {

namespace {

/// How far the reference pose is from where it was first: drift of the tracker, the base or the arm.
std::vector<double> reference_drift_mm(const std::vector<StoredPoint>& points) {
  std::vector<double> drift_mm;
  const StoredPoint* first = nullptr;
  for (const StoredPoint& point : points) {
    if (point.purpose != PointPurpose::Reference) continue;
    if (first == nullptr) first = &point;
    drift_mm.push_back((*point.p_WS_mm - *first->p_WS_mm).norm());
  }
  return drift_mm;
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
  result.reference_drift_mm = reference_drift_mm(corrected_points(points, config, resumptions).points);
  result.verdict = verdict_on(result, points, config, resumptions);
  return result;
}

CalibrationVerdict verdict_on(const CalibrationResult& result, const std::vector<StoredPoint>& points,
                              const config::CellConfig& config, const std::vector<Resumption>& resumptions) {
  const CorrectedPoints corrected = corrected_points(points, config, resumptions);
  std::vector<Eigen::Vector3d> reference_mm;
  for (const StoredPoint& point : corrected.points)
    if (point.purpose == PointPurpose::Reference) reference_mm.push_back(*point.p_WS_mm);
  const MeasurementData data = as_fitted(result.calibration, campaign_data(points, config, resumptions));
  return calibration_verdict({.calibration = result.calibration,
                              .data = data,
                              .stated = config::calibrate_options(config).noise,
                              .reference_mm = reference_mm,
                              .remeasured = result.remeasured,
                              .task_stated = config.task.is_bounded(),
                              .further_findings = corrected.findings});
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
