#include "proto/record/drift_document.hpp"

#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::record {

void layout(auto& io, Is<DriftDocument::Error> auto& x) {
  io("row", x.row, kCount);
  layout_xyz(io, x.error, kAny);
  io("length", x.length);
}
void layout(auto& io, Is<DriftDocument::Cause> auto& x) {
  io("kind", x.kind, kDriftCauses);
  if (x.kind == ChangeKind::Reflector) io("smr", x.smr);
  if (x.kind == ChangeKind::JointZero) io("joint", x.joint, kNumber);
  if (x.kind == ChangeKind::Reading) io("row", x.row, kCount);
  io("text", x.text);
  io("moved", x.moved);
  io("sigma", x.sigma);
  io("probability", x.probability);
  io("explains", x.explains);
}
void layout(auto& io, Is<ModelUpdate> auto& x) {
  io("offered", x.offered);
  io("moved", x.moved);
  io("wrong", x.wrong);
  io("doubts", x.doubts);
  io("before", x.before);
  io("after", x.after);
  io("left_out", x.left_out);
  io("probability", x.probability);
}
void layout(auto& io, Is<DriftDocument> auto& x) {
  io("verdict", x.verdict, kDriftVerdicts);
  io("reason", x.reason);
  io("mean", x.mean);
  io("max", x.max);
  io("reference", x.reference);
  io("distance2", x.distance2);
  io("degrees", x.degrees, kCount);
  io("probability", x.probability);
  io("parameters", x.uncertain_parameters, kParameterTrust);
  io("points", x.points);
  io("causes", x.causes);
  io("alternatives", x.alternatives);
  io.optional("update", x.update);
}

namespace {

std::vector<DriftDocument::Cause> causes_of(const std::vector<DriftCause>& causes, const CalibratedCell& cell,
                                            std::span<const Measurement> points) {
  std::vector<DriftDocument::Cause> result;
  for (const DriftCause& cause : causes) {
    const auto index = static_cast<std::size_t>(cause.what.index);
    result.push_back({.kind = cause.what.kind,
                      .smr = cause.what.kind == ChangeKind::Reflector ? cell.reflectors[index].name : "",
                      .joint = cause.what.index + 1,
                      .row = cause.what.kind == ChangeKind::Reading ? points[index].row : 0,
                      .text = described(cause, cell, points),
                      .moved = cause.moved,
                      .sigma = cause.sigma,
                      .probability = cause.probability,
                      .explains = cause.explains()});
  }
  return result;
}

}  // namespace

DriftDocument drift_of(const DriftCheck& check, const DriftReference& reference,
                       std::span<const Measurement> points) {
  std::vector<DriftDocument::Error> errors;
  for (std::size_t i = 0; i < points.size(); ++i)
    errors.push_back({points[i].row, check.errors_mm[i], check.errors_mm[i].norm()});
  return {.verdict = check.verdict,
          .reason = check.reason,
          .mean = check.mean_mm,
          .max = check.max_mm,
          .reference = check.reference_mm,
          .distance2 = check.distance2,
          .degrees = check.degrees,
          .probability = check.probability,
          .uncertain_parameters = reference.covariance.size() > 0,
          .points = std::move(errors),
          .causes = causes_of(check.causes, reference.cell, points),
          .alternatives = causes_of(check.alternatives, reference.cell, points)};
}

ModelUpdate update_of(const DriftUpdate& update, std::span<const Measurement> points) {
  const auto sentences = [&](const std::vector<DriftMove>& moves) {
    std::vector<std::string> all;
    for (const DriftMove& move : moves) all.push_back(described(move, update.cell, points));
    return all;
  };
  return {.offered = update.doubts.empty(),
          .moved = sentences(update.moves),
          .wrong = sentences(update.wrong),
          .doubts = update.doubts,
          .before = update.before_mm,
          .after = update.after_mm,
          .left_out = update.left_out_mm,
          .probability = update.probability};
}

boost::json::object drift_document(const DriftDocument& document) { return to_json(document); }

std::expected<DriftDocument, std::string> read_drift_document(const boost::json::object& document) {
  return from_json<DriftDocument>(document);
}

}  // namespace truepose::record
