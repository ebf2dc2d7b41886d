#include "proto/control/calibration_document.hpp"

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "core/identify/option_names.hpp"
#include "proto/control/arm_document.hpp"
#include "proto/control/transfer_document.hpp"

namespace truepose::control {
namespace {

namespace json = boost::json;

// JSON has no word for infinity or NaN, and a calibration that got there must have failed before.
double finite(double value) {
  assert(std::isfinite(value));
  return value;
}

json::object axis_json(const AxisStatistics& axis) {
  return {{"mean_abs", finite(axis.mean_abs)}, {"rms", finite(axis.rms)}, {"max", finite(axis.max_abs)}};
}

json::object xyz_json(const Eigen::Vector3d& p) {
  return {{"x", finite(p.x())}, {"y", finite(p.y())}, {"z", finite(p.z())}};
}

json::object base_json(const BasePose& base) {
  json::object result = xyz_json(base.p_mm);
  result["rx"] = finite(base.rxyz_rad.x());
  result["ry"] = finite(base.rxyz_rad.y());
  result["rz"] = finite(base.rxyz_rad.z());
  return result;
}

json::array vector_json(const Eigen::Vector3d& v) { return {finite(v.x()), finite(v.y()), finite(v.z())}; }

json::array parameters_json(const std::vector<IdentifiedParameter>& parameters) {
  json::array result;
  for (const IdentifiedParameter& p : parameters) {
    result.push_back(json::object{{"name", p.name},
                                  {"nominal", finite(p.nominal)},
                                  {"value", finite(p.value)},
                                  {"sigma", finite(p.sigma)},
                                  {"identified", p.identified},
                                  {"data_share", finite(p.data_share)}});
  }
  return result;
}

json::object deviation_json(const DeviationChoice& choice) {
  json::array groups;
  for (const DeviationGain& gain : choice.gains) {
    groups.push_back(
        json::object{{"name", gain.name}, {"chosen", gain.chosen}, {"rms_mm", finite(gain.rms_mm)}});
  }
  return {{"geometric_rms_mm", finite(choice.geometric_rms_mm)},
          {"rms_mm", finite(choice.rms_mm)},
          {"scale", finite(choice.scale)},
          {"groups", std::move(groups)}};
}

json::array sentences_json(const std::vector<Combination>& combinations) {
  json::array result;
  for (const Combination& combination : combinations) result.emplace_back(combination.sentence);
  return result;
}

json::object observability_json(const Calibration& calibration) {
  const ObservabilityIndices& o = calibration.observability;
  return {{"o1", finite(o.o1)},
          {"o2", finite(o.o2)},
          {"o3", finite(o.o3)},
          {"o4", finite(o.o4)},
          {"o5", finite(o.o5)},
          {"unknown", sentences_json(calibration.unknown)},
          {"weak", sentences_json(calibration.weak)}};
}

json::object residual_json(const RegressorSelection& selection) {
  json::array tried;
  for (const CrossValidation& kind : selection.tried) {
    tried.push_back(json::object{{"name", name_of(kind.kind)},
                                 {"rms_mm", finite(kind.rms)},
                                 {"standard_error_mm", finite(kind.standard_error)}});
  }
  return {{"chosen", selection.kind ? name_of(*selection.kind) : "none"},
          {"without_rms_mm", finite(selection.rms_zero)},
          {"tried", std::move(tried)}};
}

json::object prior_json(const Calibration& calibration) {
  if (!calibration.prior_used) return {{"used", false}};
  return {{"used", true},
          {"length_mm", finite(calibration.prior_scale.length_mm)},
          {"angle_rad", finite(calibration.prior_scale.angle_rad)}};
}

json::array rejected_json(const Calibration& calibration, const MeasurementData& data) {
  const std::vector<int> numbers = pose_numbers(data.points);
  json::array result;
  for (const RejectedPoint& rejected : calibration.rejected) {
    const Measurement& m = data.points[rejected.point];
    result.push_back(json::object{{"point", rejected.point + 1},
                                  {"row", m.row},
                                  {"pose", numbers[rejected.point] + 1},
                                  {"smr", data.smr_names[static_cast<std::size_t>(m.smr)]},
                                  {"residual_mm", finite(rejected.residual_mm)},
                                  {"sigmas", finite(rejected.sigmas)}});
  }
  return result;
}

/// What was measured at one point, in the words of a measurement file.
json::object measured_json(const RobotModel& robot, const Measurement& m, std::string_view smr) {
  json::object point{{"set", m.set == PoseSet::Identify ? "identify" : "validate"},
                     {"smr", smr},
                     {"joints", joints_json(m.q, robot)},
                     {"position", vector_json(m.p_WS_mm)}};
  if (m.sigma_mm) point["sigma"] = finite(*m.sigma_mm);
  if (!m.direction.empty()) point["direction"] = json::array(m.direction.begin(), m.direction.end());
  if (!m.time.empty()) point["time"] = m.time;
  return point;
}

json::array points_json(const Calibration& calibration, const MeasurementData& data) {
  const std::vector<int> numbers = pose_numbers(data.points);
  json::array result;
  assert(calibration.points.size() == data.points.size());
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    const Measurement& m = data.points[i];
    const PointErrors& errors = calibration.points[i];
    json::object point{{"pose", numbers[i] + 1}};
    for (auto& [key, value] :
         measured_json(calibration.cell.robot, m, data.smr_names[static_cast<std::size_t>(m.smr)])) {
      point[key] = std::move(value);
    }
    point["before"] = vector_json(errors.before);
    point["geometric"] = vector_json(errors.geometric);
    point["after"] = vector_json(errors.after);
    result.push_back(std::move(point));
  }
  return result;
}

}  // namespace

json::object statistics_json(const ErrorStatistics& s) {
  return {{"mean", finite(s.mean)}, {"rms", finite(s.rms)}, {"max", finite(s.max)}, {"min", finite(s.min)},
          {"std", finite(s.std)},   {"x", axis_json(s.x)},  {"y", axis_json(s.y)},  {"z", axis_json(s.z)}};
}

json::object stages_json(const StageErrors& stages) {
  return {{"poses", stages.poses},
          {"points", stages.points},
          {"before", statistics_json(stages.before)},
          {"geometric", statistics_json(stages.geometric)},
          {"after", statistics_json(stages.after)}};
}

json::object calibration_document(const Calibration& calibration, const MeasurementData& data,
                                  double elapsed_s) {
  json::object document{
      {"method", name_of(kMethodNames, calibration.method)},
      {"converged", calibration.converged},
      {"iterations", {{"coarse", calibration.coarse_iterations}, {"fine", calibration.fine_iterations}}},
      {"elapsed_s", finite(elapsed_s)},
      {"identify", stages_json(calibration.identify)}};
  if (calibration.validate) document["validate"] = stages_json(*calibration.validate);
  document["rank"] = calibration.rank;
  if (std::isfinite(calibration.rank_gap)) document["rank_gap"] = calibration.rank_gap;
  document["condition"] = finite(calibration.condition);
  document["sigma0_mm"] = finite(calibration.sigma0_mm);
  if (calibration.deviation) document["deviation"] = deviation_json(*calibration.deviation);
  if (calibration.residual) document["residual"] = residual_json(*calibration.residual);
  document["observability"] = observability_json(calibration);
  document["prior"] = prior_json(calibration);
  if (calibration.transfer.worst.size() > 0) document["transfer"] = transfer_json(calibration, data);
  document["rejected"] = rejected_json(calibration, data);
  document["base"] = base_json(calibration.cell.base);
  json::object smr;
  for (const Reflector& r : calibration.cell.reflectors) smr[r.name] = xyz_json(r.p_FS_mm);
  document["smr"] = std::move(smr);
  document["parameters"] = parameters_json(calibration.parameters);
  document["arm"] = arm_document(calibration.coarse.robot);
  document["points"] = points_json(calibration, data);
  return document;
}

}  // namespace truepose::control
