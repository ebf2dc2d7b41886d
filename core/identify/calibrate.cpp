#include "core/identify/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/carried_payload.hpp"
#include "core/identify/identification.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/identify/model_sanity.hpp"
#include "core/identify/open_warmth.hpp"
#include "core/identify/screening.hpp"
#include "core/identify/target_turns.hpp"
#include "core/identify/thermal_stage.hpp"
#include "core/identify/transfer_beyond.hpp"
#include "core/identify/unsuspicious.hpp"
#include "core/math/angles.hpp"
#include "core/math/parallel.hpp"

namespace truepose {
namespace {

constexpr int kFewestPoses = 5;
constexpr double kMostScreened = 0.25;  // of the points to identify

/// What keeps the points from being identified from at all.
std::optional<CalibrationError> unusable(const RobotModel& nominal, const MeasurementData& data,
                                         const CalibrateOptions& options) {
  const std::vector<Measurement> points = points_of(data, PoseSet::Identify);
  for (const Measurement& point : points) {
    const bool turned =
        !point.orientation || (point.orientation->R_WT.allFinite() && point.orientation->sigma_rad > 0);
    if (point.q.size() == nominal.joint_count() && point.q.allFinite() && point.p_WS_mm.allFinite() && turned)
      continue;
    return CalibrationError{CalibrationFault::NotFinite, told_of(data, point.station) + "row " +
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
    auto suspicion = suspect(nominal, stations > 1 ? of_station(data, s) : data, jobs);
    if (!suspicion) continue;
    suspicion->station = s;
    return CalibrationError{CalibrationFault::WrongModel, told_of(data, s) + in_words(*suspicion), suspicion};
  }
  return std::nullopt;
}

std::optional<CalibrationError> identify_geometry(Identification& id) {
  if (auto error = fit_base_and_reflectors(id)) return error;
  return fit_geometry(id);
}

Eigen::Vector3d error_mm(const Eigen::VectorXd& residuals, std::size_t point) {
  return residuals.segment<3>(3 * static_cast<Eigen::Index>(point));
}

/// The fit turns the base about the tracker's axes; what is printed are its Euler angles.
Eigen::MatrixXd printed_covariance(const Identification& id) {
  Eigen::MatrixXd printed = id.uncertainty.covariance;
  const ParameterLayout layout = ParameterLayout::of(id.fit.cell);
  for (int s = 0; s < layout.stations; ++s) {
    const Eigen::Matrix3d rates = angle_rates_zyx(id.fit.cell.base_at(s).rxyz_rad).inverse();
    const int turn = layout.base(s) + 3;
    printed.middleRows<3>(turn) = (rates * printed.middleRows<3>(turn)).eval();
    printed.middleCols<3>(turn) = (printed.middleCols<3>(turn) * rates.transpose()).eval();
  }
  return printed;
}

/// Whether the fit moved every parameter, and not only those that the data tell.
bool all_identified(const Identification& id) {
  return id.problem.free.size() > id.identified.size() && id.options.method != CalibrationMethod::TwoStage &&
         id.options.method != CalibrationMethod::GaussNewton;
}

std::vector<IdentifiedParameter> parameters(const Identification& id) {
  const Eigen::MatrixXd printed = printed_covariance(id);
  const ParameterLayout layout = ParameterLayout::of(id.fit.cell);
  const std::vector<std::string> names = parameter_names(id.fit.cell);
  const Eigen::VectorXd before = parameter_values(id.result.coarse), after = parameter_values(id.fit.cell);
  const bool all = all_identified(id);
  std::vector<IdentifiedParameter> parameters;
  for (int k = 0; k < layout.size(); ++k) {
    const bool is_link = k >= layout.link(0) && k < layout.link(layout.joints);
    const bool is_term = k >= layout.link(layout.joints);
    parameters.push_back({.name = names[static_cast<std::size_t>(k)],
                          .nominal = is_link ? before[k] : 0.0,
                          .value = after[k],
                          .sigma = std::sqrt(printed(k, k)),
                          .identified = all || is_term || std::ranges::binary_search(id.identified, k),
                          .data_share = id.uncertainty.data_share[k]});
  }
  return parameters;
}

std::vector<RejectedPoint> rejected(const Identification& id) {
  CalibratedCell judge = id.fit.cell;
  judge.robot.field = nullptr;  // came after the judgement
  const Eigen::VectorXd errors = residuals(judge, id.data.points);
  const std::vector<double> turns =
      whitened_turns(judge, id.points.points(), id.points.turn_whitening(), id.points.weights());
  std::vector<RejectedPoint> rejected;
  std::size_t i = 0;  // among the points to identify
  for (std::size_t k = 0; k < id.data.points.size(); ++k) {
    const Measurement& m = id.data.points[k];
    if (m.set != PoseSet::Identify) continue;
    if (id.points.weights()[i] == 0) {
      const Eigen::Vector3d error = error_mm(errors, k);
      const double length_mm = id.points.whitened_length(i, error);
      const bool turned = turns[i] > length_mm;
      rejected.push_back({k, error.norm(), std::max(length_mm, turns[i]) / id.points.sigma_mm(),
                          turned ? turns[i] / id.points.turn_whitening()[i] : 0});
    }
    ++i;
  }
  return rejected;
}

std::vector<PointErrors> point_errors(const Calibration& result, const MeasurementData& data) {
  const Eigen::VectorXd before = residuals(result.coarse, data.points),
                        geometric = residuals(result.geometric, data.points),
                        after = residuals(result.cell, data.points);
  std::vector<Eigen::Matrix3d> R;  // to the first station's frame
  for (int s = 0; s < data.station_count(); ++s) R.push_back(result.cell.station_pose(s).linear());
  std::vector<PointErrors> errors;
  for (std::size_t k = 0; k < data.points.size(); ++k) {
    const Eigen::Matrix3d& R_1s = R[static_cast<std::size_t>(data.points[k].station)];
    errors.push_back({R_1s * error_mm(before, k), R_1s * error_mm(geometric, k), R_1s * error_mm(after, k)});
  }
  return errors;
}

TurnStatistics turn_statistics(std::span<const Eigen::Vector3d> turns, std::span<const std::size_t> counted) {
  TurnStatistics statistics;
  double squares = 0;
  const auto count = static_cast<double>(counted.size());
  for (const std::size_t i : counted) {
    const double angle = turns[i].norm();
    statistics.mean_rad += angle / count;
    statistics.max_rad = std::max(statistics.max_rad, angle);
    squares += angle * angle;
  }
  statistics.rms_rad = std::sqrt(squares / count);
  return statistics;
}

/// @param counted  the points of the set
std::optional<TurnErrors> turn_errors(const Calibration& result, const MeasurementData& data,
                                      const std::vector<Measurement>& counted) {
  const std::vector<std::size_t> oriented = oriented_points(counted);
  if (oriented.empty()) return std::nullopt;
  std::vector<Measurement> identify;  // they alone say how a target is mounted
  for (std::size_t i = 0; i < data.points.size(); ++i)
    if (data.points[i].set == PoseSet::Identify &&
        !std::ranges::count(result.rejected, i, &RejectedPoint::point))
      identify.push_back(data.points[i]);
  const auto statistics = [&](const CalibratedCell& cell) {
    return turn_statistics(target_turns(cell, counted, best_mountings(cell, identify)), oriented);
  };
  return TurnErrors{static_cast<int>(oriented.size()), statistics(result.coarse), statistics(result.cell)};
}

/// What was screened out is left out.
///
/// @param wanted  which points
StageErrors stage_errors(const Calibration& result, const MeasurementData& data,
                         const std::function<bool(const Measurement&)>& wanted) {
  std::vector<Measurement> counted;
  std::vector<Eigen::Vector3d> before, geometric, after;
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    if (!wanted(data.points[i]) || std::ranges::count(result.rejected, i, &RejectedPoint::point)) continue;
    counted.push_back(data.points[i]);
    before.push_back(result.points[i].before);
    geometric.push_back(result.points[i].geometric);
    after.push_back(result.points[i].after);
  }
  return {.poses = count_poses(counted),
          .points = static_cast<int>(counted.size()),
          .before = error_statistics(before),
          .geometric = error_statistics(geometric),
          .after = error_statistics(after),
          .orientation_errors = turn_errors(result, data, counted)};
}

StageErrors stage_errors(const Calibration& result, const MeasurementData& data, PoseSet set) {
  return stage_errors(result, data, [set](const Measurement& m) { return m.set == set; });
}

std::vector<StationErrors> station_errors(const Calibration& result, const MeasurementData& data) {
  std::vector<StationErrors> stations;
  for (int s = 0; data.station_count() > 1 && s < data.station_count(); ++s) {
    const auto of = [&](PoseSet set) {
      return stage_errors(result, data, [=](const Measurement& m) { return m.set == set && m.station == s; });
    };
    const auto validates = [=](const Measurement& m) { return m.set == PoseSet::Validate && m.station == s; };
    StationErrors& station = stations.emplace_back(of(PoseSet::Identify));
    if (std::ranges::any_of(data.points, validates)) station.validate = of(PoseSet::Validate);
  }
  return stations;
}

/// What no noise explains, set by set.
struct Screened {
  std::vector<RejectedPoint> to_identify, to_validate;
};

/// Nothing is taken from the identification where it would be more than a few points: what most of them
/// contradict is the model, or the campaign.
Screened screened(const RobotModel& nominal, const MeasurementData& data, const CalibrateOptions& options) {
  Screened gross;
  if (options.loss != Loss::OutlierRejection) return gross;
  for (const RejectedPoint& point : gross_errors(nominal, data, options)) {
    const bool identifies = data.points[point.point].set == PoseSet::Identify;
    (identifies ? gross.to_identify : gross.to_validate).push_back(point);
  }
  const auto all = static_cast<double>(points_of(data, PoseSet::Identify).size());
  if (static_cast<double>(gross.to_identify.size()) > kMostScreened * all) gross.to_identify.clear();
  return gross;
}

/// The field is fitted to what is left at these very points, so that what it leaves there says nothing: they
/// are judged by one that did not see them.
void judge_unseen(const Identification& id, const MeasurementData& data, const Screened& gross,
                  std::vector<PointErrors>& errors) {
  std::size_t identifying = 0, trusted = 0;
  for (std::size_t k = 0; k < errors.size() && !id.unseen_mm.empty(); ++k) {
    if (data.points[k].set != PoseSet::Identify ||
        std::ranges::count(gross.to_identify, k, &RejectedPoint::point))
      continue;
    if (!id.points.trusted()[identifying++]) continue;
    const Eigen::Matrix3d R_1s = id.fit.cell.station_pose(data.points[k].station).linear();
    errors[k].after = R_1s * id.unseen_mm[trusted++];
  }
}

/// An identification up to its residual field.
struct Identified {
  std::unique_ptr<const MeasurementData> good;  ///< what it refers to
  std::unique_ptr<Identification> id;
  Screened gross;
};

/// From the points that are not screened out.
std::expected<Identified, CalibrationError> identified(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options, Screened gross) {
  auto good = std::make_unique<const MeasurementData>(without(gross.to_identify, data));
  auto id = std::make_unique<Identification>(nominal, *good, options);
  if (auto error = identify_geometry(*id)) return std::unexpected(*error);
  if (auto error = fit_deviations(*id)) return std::unexpected(*error);
  return Identified{std::move(good), std::move(id), std::move(gross)};
}

bool same_points(const std::vector<RejectedPoint>& a, const std::vector<RejectedPoint>& b) {
  return std::ranges::equal(a, b, {}, &RejectedPoint::point, &RejectedPoint::point);
}

/// A plain fit where all points agree with it; else, once the model is checked, from the points that are not
/// screened out.
///
/// @param check_model  whether the nominal arm may be one that cannot be right
/// @param expected     what is likely to be screened out: fitted without meanwhile, where threads allow
std::expected<Identified, CalibrationError> identified(const RobotModel& nominal, const MeasurementData& data,
                                                       const CalibrateOptions& options, bool check_model,
                                                       const Screened& expected) {
  if (!reweighs(options.loss)) {
    auto all = std::make_unique<const MeasurementData>(data);
    auto plain = std::make_unique<Identification>(nominal, *all, options);
    if (!identify_geometry(*plain) && is_unsuspicious(*plain)) {
      if (auto error = fit_deviations(*plain)) return std::unexpected(*error);
      return Identified{std::move(all), std::move(plain), {}};
    }
  }
  const bool alone = options.jobs < 2;  // then a refusal comes before anything is screened
  std::optional<CalibrationError> wrong;
  Screened gross;
  std::optional<std::expected<Identified, CalibrationError>> meanwhile;
  parallel_for(3, options.jobs, [&](int i) {
    if (i == 0 && check_model) wrong = wrong_model(nominal, data, options.jobs);
    if (i == 1 && !(alone && wrong)) gross = screened(nominal, data, options);
    if (i == 2 && !alone) meanwhile = identified(nominal, data, options, expected);
  });
  if (wrong) return std::unexpected(*std::move(wrong));
  if (!meanwhile || !*meanwhile || !same_points(gross.to_identify, expected.to_identify))
    return identified(nominal, data, options, std::move(gross));
  (*meanwhile)->gross = std::move(gross);
  return *std::move(meanwhile);
}

std::vector<RejectedPoint> rejected(const Identified& made) {
  return reweighs(made.id->options.loss) ? rejected(*made.id) : made.gross.to_identify;
}

ThermalBasis thermal_basis(const Identified& made) {
  const ParameterUncertainty& known = made.id->uncertainty;
  return {made.id->fit.cell, known.covariance, known.sigma0_mm, rejected(made)};
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

/// Completes the result of an identification that has been through its stages: the cell, its parameters with
/// their uncertainty, the points that were rejected, and the errors of all points through the stages.
///
/// @param data  all that was measured
Calibration summary(Identified& made, const MeasurementData& data) {
  Identification& id = *made.id;
  Calibration& result = id.result;
  result.cell = id.fit.cell;
  result.fine_solver = id.fit.solver;
  result.sigma0_mm = id.uncertainty.sigma0_mm;
  result.covariance = id.uncertainty.covariance;
  result.parameters = parameters(id);
  result.rejected = rejected(made);
  result.validation_outliers = made.gross.to_validate;
  result.points = point_errors(result, data);
  judge_unseen(id, data, made.gross, result.points);
  result.identify = stage_errors(result, data, PoseSet::Identify);
  if (std::ranges::count(data.points, PoseSet::Validate, &Measurement::set) > 0)
    result.validate = stage_errors(result, data, PoseSet::Validate);
  result.stations = station_errors(result, data);
  return std::move(result);
}

}  // namespace

void keep_first_station(Calibration& calibration) {
  const int kept = ParameterLayout::kBase;
  const auto dropped = kept * static_cast<int>(calibration.cell.further_bases.size());
  if (dropped == 0) return;
  calibration.cell.further_bases.clear();
  calibration.parameters.erase(calibration.parameters.begin() + kept,
                               calibration.parameters.begin() + kept + dropped);
  std::vector<int> rows = first_parameters(kept);
  for (int k = kept + dropped; k < calibration.covariance.rows(); ++k) rows.push_back(k);
  calibration.covariance = calibration.covariance(rows, rows).eval();
  if (!calibration.thermal || !calibration.thermal->response) return;
  Eigen::MatrixXd& with = calibration.thermal->response->covariance;
  for (int k = 0; k < calibration.thermal->response->size(); ++k)
    rows.push_back(static_cast<int>(with.cols() - calibration.thermal->response->size()) + k);
  with = with(Eigen::all, rows).eval();
}

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
  auto made = identified(nominal, data, options, options.check_model, {});
  if (!made) return std::unexpected(made.error());
  MeasurementData there;  // as it would have been at the reference temperatures
  const auto again = [&](const MeasurementData& next,
                         Screening screening) -> std::expected<ThermalBasis, CalibrationError> {
    there = next;
    made = screening == Screening::Kept ? identified(nominal, there, options, std::move(made->gross))
                                        : identified(nominal, there, options, false, made->gross);
    if (!made) return std::unexpected(made.error());
    return thermal_basis(*made);
  };
  const auto thermal = with_thermal_response(thermal_basis(*made), data, options, again);
  if (!thermal) return std::unexpected(thermal.error());
  if (!options.residual.empty()) {
    if (auto error = fit_residual(*made->id)) return std::unexpected(*error);
  }
  if (*thermal && (*thermal)->choice.clock && (*thermal)->choice.response)
    there = opened_again(std::move(there), data, *made->id, *(*thermal)->choice.response);
  const MeasurementData& fitted = there.points.empty() ? data : there;
  Calibration result = summary(*made, fitted);
  if (*thermal) {
    result.thermal = (*thermal)->choice;
    if (result.thermal->response) inflate(result, (*thermal)->inflation);
  }
  const double stated_mm = made->id->points.stated_sigma_mm();
  result.mountings = mountings(result.cell, made->id->points.trusted_points(), result.covariance,
                               stated_mm > 0 ? result.sigma0_mm / stated_mm : 1);
  result.misfit_mm = misfit_mm(*made->id);
  result.transfer = transfer_beyond(result, *made->id, fitted);
  return result;
}

}  // namespace truepose
