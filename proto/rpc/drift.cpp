#include "proto/rpc/drift.hpp"

#include "proto/record/forms.hpp"

namespace truepose::rpc {

using record::kLargeCount, record::Size, record::Whole;

void layout(Io& io, DriftCheck& x) {
  io.about("Poses to measure; default as configured").optional("poses", x.poses, Whole{1, 1000});
  io.about(
        "Bring base, reflector and joint zeros up to date by the poses, as a new model that names the "
        "old one (default false); kept where nothing speaks against it")
      .optional("update", x.update);
  io.about(
        "Work with the updated model from then on (default false); model.activate of the old one takes "
        "it back")
      .optional("activate", x.activate);
  io.about("Of the planner; default as configured").optional("seed", x.seed, kLargeCount);
  io.about(
        "What for, in the operator's words: shown with the campaign and in its report; at most 500 "
        "characters")
      .optional("note", x.note, Size{0, 500});
}
void check(const Io& io, const DriftCheck& x) {
  if (x.activate && !x.update)
    io.fail_at("activate", "only a model that was updated can be activated: give update too");
}
const Method& DriftCheck::method() {
  static const Method kMethod{
      .name = "drift.check",
      .role = Role::Operator,
      .summary = "Measures a few poses and judges whether the active model is still right",
      .description =
          "Answers once it runs, as a campaign of kind drift; the verdict is in campaign.get. Connects "
          "first where needed.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::WrongState, ErrorCode::Device,
                 ErrorCode::Busy, ErrorCode::Store},
  };
  return kMethod;
}

std::vector<Described> drift_methods() { return {described<DriftCheck>()}; }

}  // namespace truepose::rpc
