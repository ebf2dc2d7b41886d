#include "core/calibrate/summary.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/target_turns.hpp"
#include "core/math/angles.hpp"

namespace truepose {
namespace {

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

std::vector<IdentifiedParameter> parameters(const Identification& id) {
  const Eigen::MatrixXd printed = printed_covariance(id);
  const ParameterLayout layout = ParameterLayout::of(id.fit.cell);
  const std::vector<std::string> names = parameter_names(id.fit.cell);
  const Eigen::VectorXd before = parameter_values(id.result.coarse), after = parameter_values(id.fit.cell);
  std::vector<IdentifiedParameter> parameters;
  for (int k = 0; k < layout.size(); ++k) {
    const bool is_link = k >= layout.link(0) && k < layout.link(layout.joints);
    const bool is_term = k >= layout.link(layout.joints);
    parameters.push_back({.name = names[static_cast<std::size_t>(k)],
                          .nominal = is_link ? before[k] : 0.0,
                          .value = after[k],
                          .sigma = std::sqrt(printed(k, k)),
                          .identified = is_term || std::ranges::binary_search(id.identified, k),
                          .data_share = id.uncertainty.data_share[k]});
  }
  return parameters;
}

std::vector<RejectedPoint> taken_out_by_loss(const Identification& id) {
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

/// The field is fitted to what is left at these very points, so that what it leaves there says nothing: they
/// are judged by one that did not see them.
void judge_unseen(const Identification& id, const MeasurementData& data,
                  const std::vector<RejectedPoint>& left_out, std::vector<PointErrors>& errors) {
  std::size_t identifying = 0, trusted = 0;
  for (std::size_t k = 0; k < errors.size() && !id.unseen_mm.empty(); ++k) {
    if (data.points[k].set != PoseSet::Identify || std::ranges::count(left_out, k, &RejectedPoint::point))
      continue;
    if (!id.points.trusted()[identifying++]) continue;
    const Eigen::Matrix3d R_1s = id.fit.cell.station_pose(data.points[k].station).linear();
    errors[k].after = R_1s * id.unseen_mm[trusted++];
  }
}

}  // namespace

std::vector<RejectedPoint> rejected(const Identification& id, const RejectedPoints& rejected_points) {
  return reweighs(id.options.loss) ? taken_out_by_loss(id) : rejected_points.to_identify;
}

Calibration summary(const Identification& id, const RejectedPoints& rejected_points,
                    const MeasurementData& data) {
  Calibration result = id.result;
  result.cell = id.fit.cell;
  result.fine_solver = id.fit.solver;
  result.sigma0_mm = id.uncertainty.sigma0_mm;
  result.covariance = id.uncertainty.covariance;
  result.parameters = parameters(id);
  result.rejected = rejected(id, rejected_points);
  result.validation_outliers = rejected_points.to_validate;
  result.points = point_errors(result, data);
  judge_unseen(id, data, rejected_points.to_identify, result.points);
  result.identify = stage_errors(result, data, PoseSet::Identify);
  if (std::ranges::count(data.points, PoseSet::Validate, &Measurement::set) > 0)
    result.validate = stage_errors(result, data, PoseSet::Validate);
  result.stations = station_errors(result, data);
  return result;
}

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

}  // namespace truepose
