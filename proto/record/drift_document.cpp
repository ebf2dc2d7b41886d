#include "proto/record/drift_document.hpp"

#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::record {

void layout(Io& io, DriftDocument::Error& x) {
  io("row", x.row, kCount);
  layout_xyz(io, x.error, kAny);
  io("length", x.length);
}
void layout(Io& io, DriftDocument::Cause& x) {
  io("kind", x.kind, kDriftCauses);
  io.where(x.kind == ChangeKind::Reflector, "smr", x.smr);
  io.where(x.kind == ChangeKind::JointZero, "joint", x.joint, kNumber);
  io.where(x.kind == ChangeKind::Reading, "row", x.row, kCount);
  io("text", x.text);
  io("moved", x.moved);
  io("sigma", x.sigma);
  io("p_value", x.p_value);
  io("explains", x.explains);
}
void layout(Io& io, ModelUpdate& x) {
  io.record("DriftUpdate");
  io.about("Nothing speaks against the updated model")("offered", x.offered);
  io.about("What moved, with standard deviations")("moved", x.moved);
  io.about("Readings that were left out")("rejected", x.rejected);
  io.about("Why it is not offered")("warnings", x.warnings);
  io.about("Mean error of the points with the old model, mm")("before", x.before);
  io.about("With the new one")("after", x.after);
  io.about("With each point predicted by the others alone")("leave_one_out", x.leave_one_out);
  io.about("That an unchanged cell shows as much as the new model leaves")("p_value", x.p_value);
}
void layout(Io& io, DriftDocument& x) {
  io.record("DriftDocument");
  io("verdict", x.verdict, kDriftVerdicts);
  io("reason", x.reason);
  io.about("Of the errors, mm")("mean", x.mean);
  io("max", x.max);
  io.about("What the mean is judged by, mm")("reference", x.reference);
  io("chi2", x.chi2);
  io("degrees_of_freedom", x.degrees_of_freedom, kCount);
  io.about("That an unchanged cell shows as much")("p_value", x.p_value);
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
                      .p_value = cause.probability,
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
          .chi2 = check.distance2,
          .degrees_of_freedom = check.degrees,
          .p_value = check.probability,
          .uncertain_parameters = reference.covariance.size() > 0,
          .points = std::move(errors),
          .causes = causes_of(check.causes, reference.cell, points),
          .alternatives = causes_of(check.alternatives, reference.cell, points)};
}

ModelUpdate update_of(const DriftUpdate& update, std::span<const Measurement> points) {
  const auto sentences = [&](const std::vector<ChangeFound>& moves) {
    std::vector<std::string> all;
    for (const ChangeFound& move : moves) all.push_back(described_with_sigma(move, update.cell, points));
    return all;
  };
  return {.offered = update.doubts.empty(),
          .moved = sentences(update.moves),
          .rejected = sentences(update.wrong),
          .warnings = update.doubts,
          .before = update.before_mm,
          .after = update.after_mm,
          .leave_one_out = update.left_out_mm,
          .p_value = update.probability};
}

boost::json::object drift_document(const DriftDocument& document) { return to_json(document); }

}  // namespace truepose::record
