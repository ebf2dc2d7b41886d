#include "proto/control/calibration_document.hpp"

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "core/kinematics/angles.hpp"

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

json::object stages_json(const StageErrors& stages) {
  return {{"poses", stages.poses},
          {"points", stages.points},
          {"before", statistics_json(stages.before)},
          {"geometric", statistics_json(stages.geometric)},
          {"after", statistics_json(stages.after)}};
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

json::array joints_json(const RobotModel& robot, const JointVector& q) {
  json::array result;
  for (int i = 0; i < robot.joint_count(); ++i) {
    const bool revolute = robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
    result.emplace_back(finite(revolute ? q[i] * kDegPerRad : q[i]));
  }
  return result;
}

std::string_view method_name(CalibrationMethod method) {
  switch (method) {
    case CalibrationMethod::TwoStage:
      return "two-stage";
    case CalibrationMethod::LeastSquares:
      return "least-squares";
  }
  return "";
}

json::array parameters_json(const std::vector<IdentifiedParameter>& parameters) {
  json::array result;
  for (const IdentifiedParameter& p : parameters) {
    result.push_back(json::object{{"name", p.name},
                                  {"nominal", finite(p.nominal)},
                                  {"value", finite(p.value)},
                                  {"sigma", finite(p.sigma)},
                                  {"identified", p.identified}});
  }
  return result;
}

/// The number of each point's pose, from 1 in the order of first appearance.
std::vector<int> pose_numbers(const std::vector<Measurement>& points) {
  std::vector<const JointVector*> poses;
  std::vector<int> result;
  for (const Measurement& m : points) {
    std::size_t k = 0;
    while (k < poses.size() && *poses[k] != m.q) ++k;
    if (k == poses.size()) poses.push_back(&m.q);
    result.push_back(static_cast<int>(k) + 1);
  }
  return result;
}

json::array points_json(const Calibration& calibration, const MeasurementData& data) {
  const std::vector<int> numbers = pose_numbers(data.points);
  json::array result;
  assert(calibration.points.size() == data.points.size());
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    const PointErrors& errors = calibration.points[i];
    const Measurement& m = data.points[i];
    result.push_back(json::object{{"pose", numbers[i]},
                                  {"set", m.set == PoseSet::Identify ? "identify" : "validate"},
                                  {"smr", data.smr_names[static_cast<std::size_t>(m.smr)]},
                                  {"joints", joints_json(calibration.cell.robot, m.q)},
                                  {"before", vector_json(errors.before)},
                                  {"geometric", vector_json(errors.geometric)},
                                  {"after", vector_json(errors.after)}});
  }
  return result;
}

}  // namespace

json::object statistics_json(const ErrorStatistics& s) {
  return {{"mean", finite(s.mean)}, {"rms", finite(s.rms)}, {"max", finite(s.max)}, {"min", finite(s.min)},
          {"std", finite(s.std)},   {"x", axis_json(s.x)},  {"y", axis_json(s.y)},  {"z", axis_json(s.z)}};
}

json::object calibration_document(const Calibration& calibration, const MeasurementData& data,
                                  double elapsed_s) {
  json::object document{
      {"method", method_name(calibration.method)},
      {"converged", calibration.converged},
      {"iterations", {{"coarse", calibration.coarse_iterations}, {"fine", calibration.fine_iterations}}},
      {"elapsed_s", finite(elapsed_s)},
      {"identify", stages_json(calibration.identify)}};
  if (calibration.validate) document["validate"] = stages_json(*calibration.validate);
  document["rank"] = calibration.rank;
  document["condition"] = finite(calibration.condition);
  document["base"] = base_json(calibration.cell.base);
  json::object smr;
  for (const Reflector& r : calibration.cell.reflectors) smr[r.name] = xyz_json(r.p_FS_mm);
  document["smr"] = std::move(smr);
  document["parameters"] = parameters_json(calibration.parameters);
  document["points"] = points_json(calibration, data);
  return document;
}

}  // namespace truepose::control
