#include "proto/rpc/model.hpp"

namespace truepose::rpc {

using record::kCount, record::Range, record::Whole;

void layout(Io& io, ModelSummary& x) {
  io.record("ModelSummary");
  io.about("The model").format("uuid")("id", x.id);
  io.about("When").format("date-time")("created", x.created);
  io.about("The campaign that made it").format("uuid")("campaign_id", x.campaign_id);
  io.about("Of the arm it was identified on")("robot_serial", x.robot_serial);
  io.about("Mean error of the nominal arm on validation poses; null = not validated")
      .nullable("validation_before_mm", x.validation_before_mm);
  io.about("Mean error of this model there").nullable("validation_after_mm", x.validation_after_mm);
  io("active", x.active);
  io.about("Of the active model: its verdict where that is amber or red, and why")
      .optional("warning", x.warning);
}

void layout(Io& io, Parameter& x) {
  io.record("Parameter");
  io.about("link2.a, base.x, smr.1.z")("name", x.name);
  io.about("mm or rad")("nominal", x.nominal);
  io("value", x.value);
  io.about("Standard deviation; 0 where not identified")("sigma", x.sigma);
  io("identified", x.identified);
  io.about("1 where the data alone determine it, less where the prior does")
      .optional("data_share", x.data_share, Range{0, 1});
}

void layout(Io& io, ModelList::Result& x) {
  io("models", x.models);
  io.about("Of all")("total", x.total, kCount);
}
void layout(Io& io, ModelList& x) {
  io.about("At most so many").defaulted("limit", x.limit, Whole{1, 100});
  io.about("Skip so many, newest first").defaulted("offset", x.offset);
}
const Method& ModelList::method() {
  static const Method kMethod{
      .name = "model.list",
      .summary = "Models, newest first",
  };
  return kMethod;
}

void layout(Io& io, ModelGet::Result& x) {
  io("model", x.model);
  io("parameters", x.parameters);
}
void layout(Io& io, ModelGet& x) {
  io.about("Default: the active one").format("uuid").optional("id", x.id, kIdSize);
}
const Method& ModelGet::method() {
  static const Method kMethod{
      .name = "model.get",
      .summary = "One model with its parameters",
      .errors = {ErrorCode::NotFound, ErrorCode::WrongState, ErrorCode::Store},
  };
  return kMethod;
}

void layout(Io& io, ModelActivate& x) { io.about("The model").format("uuid")("id", x.id, kIdSize); }
const Method& ModelActivate::method() {
  static const Method kMethod{
      .name = "model.activate",
      .role = Role::Engineer,
      .summary = "Makes this model the one that corrects; a running stream ramps over to it",
      .description =
          "Refused unless its validation beats the nominal arm and the arm is the one it was identified on.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::NotFound, ErrorCode::WrongState,
                 ErrorCode::Store},
  };
  return kMethod;
}

const Method& ModelRollback::method() {
  static const Method kMethod{
      .name = "model.rollback",
      .role = Role::Engineer,
      .summary = "Activates the model that was active before the one of now",
      .description =
          "Where none is active: the one that was last. As model.activate, with the same checks. A second "
          "rollback leads back.",
      .errors = {ErrorCode::Unauthenticated, ErrorCode::WrongState, ErrorCode::NotFound, ErrorCode::Store},
  };
  return kMethod;
}

void layout(Io& io, ModelDeactivate::Result& x) {
  io.about("The model that was active").nullable("deactivated", x.deactivated);
}
const Method& ModelDeactivate::method() {
  static const Method kMethod{
      .name = "model.deactivate",
      .role = Role::Engineer,
      .summary = "No model corrects any more; a running stream ramps out",
      .errors = {ErrorCode::Forbidden, ErrorCode::WrongState},
      .is_always_carried_out = true,
  };
  return kMethod;
}

void layout(Io& io, ModelExport::Result& x) {
  io.about("The model").format("uuid")("id", x.id);
  io.about("Text of the file")("yaml", x.yaml);
}
void layout(Io& io, ModelExport& x) {
  io.about("Default: the active one").format("uuid").optional("id", x.id, kIdSize);
}
const Method& ModelExport::method() {
  static const Method kMethod{
      .name = "model.export",
      .summary = "The model file",
      .errors = {ErrorCode::NotFound, ErrorCode::Store},
  };
  return kMethod;
}

std::vector<Described> model_methods() {
  return {described<ModelList>(),     described<ModelGet>(),        described<ModelActivate>(),
          described<ModelRollback>(), described<ModelDeactivate>(), described<ModelExport>()};
}

}  // namespace truepose::rpc
