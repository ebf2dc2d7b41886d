#include "core/calibration/calibrate.hpp"

#include <algorithm>

#include "core/calibration/calibration_summary.hpp"
#include "core/calibration/identification.hpp"
#include "core/calibration/model_sanity.hpp"

namespace truepose {
namespace {

constexpr int kFewestPoses = 5;
constexpr int kMaxRounds = 4;

/// What keeps the points from being identified from at all.
std::optional<CalibrationError> unusable(const Identification& id) {
  const std::vector<Measurement>& points = id.points.points();
  for (const Measurement& point : points) {
    if (point.q.size() == id.nominal.joint_count() && point.q.allFinite() && point.p_WS_mm.allFinite())
      continue;
    return CalibrationError{CalibrationFault::NotFinite,
                            "row " + std::to_string(point.row) + " holds a number that is not finite"};
  }
  const std::vector<std::string>& smr_names = id.data.smr_names;
  for (std::size_t k = 0; k < smr_names.size(); ++k) {
    const auto is_of_it = [k](const Measurement& m) { return static_cast<std::size_t>(m.smr) == k; };
    if (std::ranges::any_of(points, is_of_it)) continue;
    return CalibrationError{CalibrationFault::TooFewPoses,
                            "reflector '" + smr_names[k] + "' has no point to identify it from"};
  }
  const int poses = count_poses(points);
  if (poses >= kFewestPoses) return std::nullopt;
  return CalibrationError{CalibrationFault::TooFewPoses,
                          std::to_string(poses) + " poses to identify from; base and reflector alone need " +
                              std::to_string(kFewestPoses)};
}

std::optional<CalibrationError> wrong_model(const Identification& id) {
  if (!id.options.check_model) return std::nullopt;
  const auto suspicion = suspect(id.nominal, id.data);
  if (!suspicion) return std::nullopt;
  return CalibrationError{CalibrationFault::WrongModel, suspicion->sentence};
}

/// The geometry and the deviations of the joints. What is a gross error to the geometry alone may be a good
/// point to the richer model, or hide from the poorer one: until both trust the same points, they are fitted
/// again from those that the richer one trusts.
std::optional<CalibrationError> fit_joints(Identification& id) {
  if (auto error = fit_geometry(id)) return error;
  for (int round = 0; id.options.deviation && round < kMaxRounds; ++round) {
    const std::vector<bool> chosen_from = id.points.trusted();
    fit_deviations(id);
    if (id.points.trusted() == chosen_from || round + 1 == kMaxRounds) break;
    if (auto error = fit_geometry(id, Weighing::Kept)) return error;
  }
  return std::nullopt;
}

/// The stages that the options ask for.
std::optional<CalibrationError> identify(Identification& id) {
  if (auto error = unusable(id)) return error;
  if (auto error = fit_base_and_reflectors(id)) return error;
  if (auto error = wrong_model(id)) return error;
  if (auto error = fit_joints(id)) return error;
  if (!id.options.residual.empty()) return fit_residual(id);
  return std::nullopt;
}

}  // namespace

std::expected<CalibratedCell, CalibrationError> coarse_fit(const RobotModel& arm,
                                                           const MeasurementData& data) {
  MeasurementData all = data;
  for (Measurement& point : all.points) point.set = PoseSet::Identify;
  const CalibrateOptions options;
  Identification id(arm, all, options);
  if (auto error = unusable(id)) return std::unexpected(*error);
  if (auto error = fit_base_and_reflectors(id)) return std::unexpected(*error);
  return id.fit.cell;
}

std::expected<Calibration, CalibrationError> calibrate(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options) {
  Identification id(nominal, data, options);
  if (auto error = identify(id)) return std::unexpected(*error);
  return summary(std::move(id));
}

}  // namespace truepose
