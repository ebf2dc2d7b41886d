#include "proto/record/calibration_content.hpp"

#include <boost/json/object.hpp>
#include <cassert>
#include <cmath>

#include "core/calibrate/option_names.hpp"
#include "core/math/angles.hpp"
#include "core/math/units.hpp"
#include "proto/record/forms.hpp"

namespace truepose::record {

namespace json = boost::json;

namespace {

std::vector<std::string> sentences(const std::vector<Combination>& combinations) {
  std::vector<std::string> result;
  for (const Combination& combination : combinations) result.push_back(combination.sentence);
  return result;
}

std::string station_of(const Measurement& m, const MeasurementData& data) {
  return data.station_count() > 1 ? data.stations[static_cast<std::size_t>(m.station)] : "";
}

std::vector<Station> stations_of(const Calibration& c, const MeasurementData& data) {
  std::vector<Station> stations;
  for (std::size_t s = 0; s < c.stations.size(); ++s)
    stations.push_back({.name = data.stations[s],
                        .base = c.cell.base_at(static_cast<int>(s)),
                        .identify = c.stations[s].identify,
                        .validate = c.stations[s].validate});
  return stations;
}

Rejected rejected_of(const RejectedPoint& rejected, const MeasurementData& data,
                     const std::vector<int>& poses) {
  const Measurement& m = data.points[rejected.point];
  return {.point = rejected.point + 1,
          .row = m.row,
          .pose = poses[rejected.point],
          .smr = data.smr_names[static_cast<std::size_t>(m.smr)],
          .station = station_of(m, data),
          .residual_mm = rejected.residual_mm,
          .sigmas = rejected.sigmas,
          .orientation_error_rad = rejected.turn_rad};
}

std::optional<TurnedTarget> turned_target(const Measurement& m, const CalibratedCell& cell) {
  if (!m.orientation) return std::nullopt;
  const Eigen::Vector3d abc = kuka_abc_deg(cell.station_pose(m.station).linear() * m.orientation->R_WT);
  return TurnedTarget{abc[0], abc[1], abc[2], m.orientation->sigma_rad * kDegPerRad};
}

std::vector<MountedTarget> targets_of(const Calibration& c) {
  std::vector<MountedTarget> targets;
  for (std::size_t k = 0; k < c.mountings.size(); ++k)
    if (const auto& mounting = c.mountings[k])
      targets.push_back({c.cell.reflectors[k].name, angles_zyx(mounting->R_FT), mounting->sigma_rad});
  return targets;
}

Point point_of(const Measurement& m, const MeasurementData& data, const CalibratedCell& cell, int pose,
               const PointErrors& errors) {
  const Eigen::Vector3d p_mm = m.station == 0 ? m.p_WS_mm : cell.station_pose(m.station) * m.p_WS_mm;
  return {.station = station_of(m, data),
          .pose = pose,
          .set = m.set,
          .smr = data.smr_names[static_cast<std::size_t>(m.smr)],
          .joints = in_deg_mm(m.q, cell.robot),
          .position = p_mm,
          .sigma = m.sigma_mm,
          .excess = m.excess_mm > 0 ? std::optional{m.excess_mm} : std::nullopt,
          .orientation = turned_target(m, cell),
          .direction = m.direction,
          .payload = m.payload,
          .time = m.time,
          .before = errors.before,
          .geometric = errors.geometric,
          .after = errors.after};
}

Thermal thermal_of(const ThermalChoice& choice, const RobotModel& robot) {
  Thermal x{.chosen = choice.response.has_value(),
            .without_rms_mm = choice.without_rms_mm,
            .rms_mm = choice.rms_mm,
            .reference_c = {},
            .zero_per_k = {}};
  if (choice.clock)
    (choice.clock->by_order ? x.time_constant_poses : x.time_constant_s) = choice.clock->constant;
  if (!choice.response) return x;
  x.reference_c = choice.response->reference_c;
  const Eigen::VectorXd& per_kelvin = choice.response->per_kelvin;
  x.zero_per_k = in_deg_mm(per_kelvin.head(robot.joint_count()), robot);
  x.expansion_ppm_per_k = 1e6 * per_kelvin[robot.joint_count()];
  return x;
}

std::string harmonics_text(const CalibrateOptions& options) {
  std::string text;
  for (const int order : options.harmonics) text += (text.empty() ? "" : ", ") + std::to_string(order);
  return text;
}

}  // namespace

ByName<std::string> options_in_words(const CalibrateOptions& options) {
  ByName<std::string> words{{"Loss", std::string{name_of(kLossNames, options.loss)}},
                            {"Prior", std::string{name_of(kPriorNames, options.prior)}},
                            {"Non-geometric errors", options.non_geometric ? "auto" : "none"},
                            {"Residual field", std::string{name_of(kFieldNames, options.field)}},
                            {"Warmth", std::string{name_of(kThermalNames, options.thermal)}}};
  if (options.non_geometric) words.emplace_back("Harmonics looked for", harmonics_text(options));
  return words;
}

CalibrationDocument calibration_of(const Calibration& c, const MeasurementData& data, double elapsed_s) {
  assert(c.points.size() == data.points.size());
  const std::vector<int> poses = named_pose_numbers(data.points);
  CalibrationDocument x;
  x.converged = c.converged;
  x.iterations = {c.coarse_iterations, c.fine_iterations};
  x.elapsed_s = elapsed_s;
  x.identify = c.identify;
  x.validate = c.validate;
  x.rank = c.rank;
  if (std::isfinite(c.rank_gap)) x.rank_gap = c.rank_gap;
  x.condition = c.observability.o2 > 0 ? c.observability.condition() : 0;  // of no parameter
  x.sigma0_mm = c.sigma0_mm;
  x.non_geometric = c.non_geometric;
  x.field = c.field;
  if (c.thermal) x.thermal = thermal_of(*c.thermal, c.cell.robot);
  x.observability = {c.observability, sentences(c.unknown), sentences(c.weak)};
  x.prior = {c.prior_used, c.prior_scale};
  if (c.transfer.worst.size() > 0) x.prediction_uncertainty = transfer_of(c, data);
  for (const RejectedPoint& rejected : c.rejected) x.rejected.push_back(rejected_of(rejected, data, poses));
  for (const RejectedPoint& far : c.validation_outliers)
    x.validation_outliers.push_back(rejected_of(far, data, poses));
  x.base = c.cell.base;
  x.stations = stations_of(c, data);
  x.smr = c.cell.reflectors;
  x.targets = targets_of(c);
  x.parameters = c.parameters;
  x.arm = Arm::of(c.coarse.robot);
  for (std::size_t i = 0; i < data.points.size(); ++i)
    x.points.push_back(point_of(data.points[i], data, c.cell, poses[i], c.points[i]));
  return x;
}

json::object calibration_document(const Calibration& calibration, const MeasurementData& data,
                                  double elapsed_s) {
  return calibration_document(calibration_of(calibration, data, elapsed_s));
}

}  // namespace truepose::record
