#include "core/calibrate/calibrate.hpp"

#include <algorithm>
#include <utility>

#include "core/calibrate/identification.hpp"
#include "core/calibrate/outlier_rejection.hpp"
#include "core/calibrate/quick_check.hpp"
#include "core/calibrate/summary.hpp"
#include "core/calibrate/thermal_stage.hpp"
#include "core/calibrate/transfer_beyond.hpp"
#include "core/data/calibrated_cell.hpp"
#include "core/data/carried_payload.hpp"
#include "core/diagnosis/model_sanity.hpp"
#include "core/fit/open_warmth.hpp"
#include "core/fit/target_turns.hpp"
#include "core/math/parallel.hpp"

namespace truepose {
namespace {

constexpr int kFewestPoses = 5;
constexpr double kMaxRejectedShare = 0.25;  // of the points to identify
constexpr int kThermalRounds = 2;

/// What keeps the points from being identified from at all.
std::optional<CalibrationError> unusable(const RobotModel& nominal, const MeasurementData& data,
                                         const CalibrateOptions& options) {
  const std::vector<Measurement> points = points_of(data, PoseSet::Identify);
  for (const Measurement& point : points) {
    const bool turned =
        !point.orientation || (point.orientation->R_WT.allFinite() && point.orientation->sigma_rad > 0);
    if (point.q.size() == nominal.joint_count() && point.q.allFinite() && point.p_WS_mm.allFinite() && turned)
      continue;
    return CalibrationError{CalibrationFault::NotFinite, station_prefix(data, point.station) + "row " +
                                                             std::to_string(point.row) +
                                                             " holds a number that is not finite"};
  }
  const std::vector<std::string>& smr_names = data.smr_names;
  for (std::size_t k = 0; k < smr_names.size(); ++k) {
    const auto is_of_it = [k](const Measurement& m) { return static_cast<std::size_t>(m.smr) == k; };
    if (std::ranges::any_of(points, is_of_it)) continue;
    return CalibrationError{CalibrationFault::TooFewPoses,
                            "reflector '" + smr_names[k] + "' has no point to identify it from"};
  }
  for (std::size_t s = 0; s < data.stations.size(); ++s) {
    const auto is_from_it = [s](const Measurement& m) { return static_cast<std::size_t>(m.station) == s; };
    if (std::ranges::any_of(points, is_from_it)) continue;
    return CalibrationError{CalibrationFault::TooFewPoses,
                            "station '" + data.stations[s] + "' has no point to identify its base from"};
  }
  if (!oriented_points(points).empty() && !(whitening_of(points, options.noise).finest_mm > 0))
    return CalibrationError{
        CalibrationFault::NoNoise,
        "orientations are weighed against positions, and the noise of these is not known: state sigma "
        "for every point, or the tracker's noise"};
  const int poses = count_poses(points);
  if (poses >= kFewestPoses) return std::nullopt;
  return CalibrationError{CalibrationFault::TooFewPoses,
                          std::to_string(poses) + " poses to identify from; base and reflector alone need " +
                              std::to_string(kFewestPoses)};
}

/// Before anything is screened: under a wrong arm good points seem gross. Stations are looked at one by one,
/// as any mistake of the robot file shows from each.
std::optional<CalibrationError> wrong_model(const RobotModel& nominal, const MeasurementData& data,
                                            int jobs) {
  const int stations = data.station_count();
  for (int s = 0; s < stations; ++s) {
    auto cause = diagnose_files(nominal, stations > 1 ? of_station(data, s) : data, jobs);
    if (!cause) continue;
    cause->station = s;
    return CalibrationError{CalibrationFault::WrongModel, station_prefix(data, s) + in_words(*cause), cause};
  }
  return std::nullopt;
}

/// Nothing is taken from the identification where it would be more than a few points: what most of them
/// contradict is the model, or the campaign.
RejectedPoints reject_outliers(const RobotModel& nominal, const MeasurementData& data,
                               const CalibrateOptions& options) {
  RejectedPoints outliers;
  if (options.loss != Loss::OutlierRejection) return outliers;
  for (const RejectedPoint& point : find_outliers(nominal, data, options)) {
    const bool identifies = data.points[point.point].set == PoseSet::Identify;
    (identifies ? outliers.to_identify : outliers.to_validate).push_back(point);
  }
  const auto all = static_cast<double>(points_of(data, PoseSet::Identify).size());
  if (static_cast<double>(outliers.to_identify.size()) > kMaxRejectedShare * all)
    outliers.to_identify.clear();
  return outliers;
}

/// An identification up to its residual field.
struct Identified {
  Identification id;
  RejectedPoints outliers;  ///< what it was made without
};

/// Geometry and deviations from the points that are not screened out.
std::expected<Identified, CalibrationError> identified(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options,
                                                       RejectedPoints outliers) {
  Identification id(nominal, without(outliers.to_identify, data), options);
  if (auto error = fit_base_and_reflectors(id)) return std::unexpected(*error);
  if (auto error = fit_geometry(id)) return std::unexpected(*error);
  if (auto error = fit_deviations(id)) return std::unexpected(*error);
  return Identified{std::move(id), std::move(outliers)};
}

/// From all points, where a plain fit agrees with them all.
std::optional<std::expected<Identified, CalibrationError>> identified_from_all(
    const RobotModel& nominal, const MeasurementData& data, const CalibrateOptions& options) {
  if (reweighs(options.loss)) return std::nullopt;
  Identification id(nominal, data, options);
  if (fit_base_and_reflectors(id) || fit_geometry(id) || !passes_quick_check(id)) return std::nullopt;
  if (auto error = fit_deviations(id)) return std::unexpected(*error);
  return Identified{std::move(id), {}};
}

/// A plain fit where all points agree with it; else, once the model is checked, from the points that are not
/// screened out.
///
/// @param check_model  whether the nominal arm may be one that cannot be right
std::expected<Identified, CalibrationError> identified(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options, bool check_model) {
  if (auto all = identified_from_all(nominal, data, options)) return *std::move(all);
  const bool alone = options.jobs < 2;  // then a refusal comes before anything is screened
  std::optional<CalibrationError> wrong;
  RejectedPoints outliers;
  parallel_for(2, options.jobs, [&](int i) {
    if (i == 0 && check_model) wrong = wrong_model(nominal, data, options.jobs);
    if (i == 1 && !(alone && wrong)) outliers = reject_outliers(nominal, data, options);
  });
  if (wrong) return std::unexpected(*std::move(wrong));
  return identified(nominal, data, options, std::move(outliers));
}

ThermalBasis thermal_basis(const Identified& made) {
  const ParameterUncertainty& known = made.id.uncertainty;
  return {made.id.fit.cell, known.covariance, known.sigma0_mm, rejected(made.id, made.outliers)};
}

/// The points whose warmth is open, brought to the reference by the whole model.
///
/// @param there  all points at the reference
/// @param data   as they were measured
MeasurementData opened_again(MeasurementData there, const MeasurementData& data, const Identification& id,
                             const ThermalResponse& response) {
  for (std::size_t i = 0; i < there.points.size(); ++i)
    if (warmth_is_open(there.points[i])) there.points[i].p_WS_mm = data.points[i].p_WS_mm;
  return with_open_warmth(std::move(there), id.fit.cell, response, id.uncertainty.sigma0_mm);
}

}  // namespace

MeasurementData as_fitted(const Calibration& calibration, const MeasurementData& data) {
  if (!calibration.thermal || !calibration.thermal->response) return data;
  const ThermalResponse& response = *calibration.thermal->response;
  const auto& clock = calibration.thermal->clock;
  if (!clock) return at_reference(data, calibration.cell, response);
  return with_open_warmth(at_reference(with_warmth_by(*clock, data), calibration.cell, response),
                          calibration.cell, response, calibration.sigma0_mm);
}

std::expected<CalibratedCell, CalibrationError> coarse_fit(const RobotModel& arm,
                                                           const MeasurementData& data) {
  MeasurementData all = data;
  for (Measurement& point : all.points) point.set = PoseSet::Identify;
  const CalibrateOptions options;
  for (Measurement& point : all.points) point.orientation.reset();  // positions place the base
  if (auto error = unusable(arm, all, options)) return std::unexpected(*error);
  Identification id(arm, all, options);
  if (auto error = fit_base_and_reflectors(id)) return std::unexpected(*error);
  return id.fit.cell;
}

std::expected<Calibration, CalibrationError> calibrate(const RobotModel& robot, const MeasurementData& data,
                                                       const CalibrateOptions& options) {
  const RobotModel nominal = carrying_as_measured(robot, data.points);
  if (auto error = unusable(nominal, data, options)) return std::unexpected(*error);
  auto made = identified(nominal, data, options, options.check_model);
  if (!made) return std::unexpected(made.error());

  MeasurementData fitted = data;  // as it would have been at the reference temperatures
  auto thermal = thermal_stage(thermal_basis(*made), data, options);
  for (int round = 1; thermal && thermal->pays && round <= kThermalRounds; ++round) {
    fitted = at_reference(*thermal, thermal_basis(*made));
    // The last round alone knows warmth well enough to tell it from an outlier.
    made = round < kThermalRounds ? identified(nominal, fitted, options, std::move(made->outliers))
                                  : identified(nominal, fitted, options, false);
    if (!made) return std::unexpected(made.error());
    refine(*thermal, thermal_basis(*made), fitted, options);
  }
  if (options.field != FieldUse::None) {
    if (auto error = fit_field(made->id)) return std::unexpected(*error);
  }
  if (thermal && thermal->pays && thermal->clock)
    fitted = opened_again(std::move(fitted), data, made->id, thermal->response);

  Calibration result = summary(made->id, made->outliers, fitted);
  if (thermal) add_thermal_choice(*thermal, result);
  const double stated_mm = made->id.points.stated_sigma_mm();
  result.mountings = mountings(result.cell, made->id.points.trusted_points(), result.covariance,
                               stated_mm > 0 ? result.sigma0_mm / stated_mm : 1);
  result.misfit_mm = misfit_mm(made->id);
  result.transfer = transfer_beyond(result, made->id, fitted);
  return result;
}

}  // namespace truepose
