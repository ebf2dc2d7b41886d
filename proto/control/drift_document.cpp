#include "proto/control/drift_document.hpp"

#include <boost/json/array.hpp>
#include <cmath>
#include <vector>

namespace truepose::control {

namespace json = boost::json;

namespace {

json::array numbers(const Eigen::VectorXd& vector) { return json::array(vector.begin(), vector.end()); }

json::object cause_json(const DriftCause& cause, const CalibratedCell& cell,
                        std::span<const Measurement> points) {
  json::object object;
  const auto index = static_cast<std::size_t>(cause.index);
  switch (cause.kind) {
    case DriftCauseKind::Base:
      object["kind"] = "base";
      break;
    case DriftCauseKind::Reflector:
      object = {{"kind", "reflector"}, {"smr", cell.reflectors[index].name}};
      break;
    case DriftCauseKind::JointZero:
      object = {{"kind", "joint_zero"}, {"joint", cause.index + 1}};
      break;
    case DriftCauseKind::Reading:
      object = {{"kind", "reading"}, {"row", points[index].row}};
      break;
  }
  object["text"] = described(cause, cell, points);
  object["moved"] = numbers(cause.moved);
  object["sigma"] = numbers(cause.sigma);
  object["probability"] = cause.probability;
  object["explains"] = cause.explains();
  return object;
}

json::array causes_json(const std::vector<DriftCause>& causes, const CalibratedCell& cell,
                        std::span<const Measurement> points) {
  json::array array;
  for (const DriftCause& cause : causes) array.push_back(cause_json(cause, cell, points));
  return array;
}

}  // namespace

std::string_view verdict_name(DriftVerdict verdict) {
  switch (verdict) {
    case DriftVerdict::Ok:
      return "ok";
    case DriftVerdict::Warning:
      return "warning";
    case DriftVerdict::Failed:
      return "failed";
  }
  return {};
}

json::object drift_document(const DriftCheck& check, const DriftReference& reference,
                            std::span<const Measurement> points) {
  const CalibratedCell& cell = reference.cell;
  json::array errors;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d& e = check.errors_mm[i];
    errors.push_back(
        json::object{{"row", points[i].row}, {"x", e.x()}, {"y", e.y()}, {"z", e.z()}, {"length", e.norm()}});
  }
  return {{"verdict", verdict_name(check.verdict)},
          {"reason", check.reason},
          {"mean", check.mean_mm},
          {"max", check.max_mm},
          {"reference", check.reference_mm},
          {"distance2", check.distance2},
          {"degrees", check.degrees},
          {"probability", check.probability},
          {"parameters", reference.covariance.size() > 0 ? "uncertain" : "taken as exact"},
          {"points", std::move(errors)},
          {"causes", causes_json(check.causes, cell, points)},
          {"alternatives", causes_json(check.alternatives, cell, points)}};
}

}  // namespace truepose::control
