#include "core/identify/calibrate.hpp"

#include <algorithm>
#include <cmath>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/identification.hpp"
#include "core/identify/measurement_model.hpp"
#include "core/identify/model_sanity.hpp"
#include "core/math/angles.hpp"

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

Eigen::Vector3d error_mm(const Eigen::VectorXd& residuals, std::size_t point) {
  return residuals.segment<3>(3 * static_cast<Eigen::Index>(point));
}

/// The fit turns the base about the tracker's axes; what is printed are its Euler angles.
Eigen::MatrixXd printed_covariance(const Identification& id) {
  Eigen::MatrixXd printed = id.uncertainty.covariance;
  const Eigen::Matrix3d rates = angle_rates_zyx(id.fit.cell.base.rxyz_rad).inverse();
  printed.middleRows<3>(3) = (rates * printed.middleRows<3>(3)).eval();
  printed.middleCols<3>(3) = (printed.middleCols<3>(3) * rates.transpose()).eval();
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
  std::vector<RejectedPoint> rejected;
  std::size_t i = 0;  // among the points to identify
  for (std::size_t k = 0; k < id.data.points.size(); ++k) {
    const Measurement& m = id.data.points[k];
    if (m.set != PoseSet::Identify) continue;
    if (id.points.weights()[i] == 0) {
      const Eigen::Vector3d error = error_mm(errors, k);
      rejected.push_back({k, error.norm(), id.points.whitened_length(i, error) / id.points.sigma_mm()});
    }
    ++i;
  }
  return rejected;
}

std::vector<PointErrors> point_errors(const Calibration& result, const MeasurementData& data) {
  const Eigen::VectorXd before = residuals(result.coarse, data.points),
                        geometric = residuals(result.geometric, data.points),
                        after = residuals(result.cell, data.points);
  std::vector<PointErrors> errors;
  for (std::size_t k = 0; k < data.points.size(); ++k)
    errors.push_back({error_mm(before, k), error_mm(geometric, k), error_mm(after, k)});
  return errors;
}

StageErrors stage_errors(const Calibration& result, const MeasurementData& data, PoseSet set) {
  std::vector<Eigen::Vector3d> before, geometric, after;
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    if (data.points[i].set != set) continue;
    before.push_back(result.points[i].before);
    geometric.push_back(result.points[i].geometric);
    after.push_back(result.points[i].after);
  }
  return {.poses = count_poses(points_of(data, set)),
          .points = static_cast<int>(before.size()),
          .before = error_statistics(before),
          .geometric = error_statistics(geometric),
          .after = error_statistics(after)};
}

/// Completes the result of an identification that has been through its stages: the cell, its parameters with
/// their uncertainty, the points that were rejected, and the errors of all points through the stages.
Calibration summary(Identification id) {
  Calibration& result = id.result;
  result.cell = id.fit.cell;
  result.fine_solver = id.fit.solver;
  result.sigma0_mm = id.uncertainty.sigma0_mm;
  result.covariance = id.uncertainty.covariance;
  result.parameters = parameters(id);
  result.rejected = rejected(id);
  result.points = point_errors(result, id.data);
  result.identify = stage_errors(result, id.data, PoseSet::Identify);
  if (result.identify.points < static_cast<int>(id.data.points.size()))
    result.validate = stage_errors(result, id.data, PoseSet::Validate);
  return std::move(result);
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
