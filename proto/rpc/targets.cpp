#include "proto/rpc/targets.hpp"

namespace truepose::rpc {

using record::kCount, record::Size, record::Whole;

void layout(Io& io, TargetsCompensate::Result& x) {
  io.about("deg (mm for a prismatic joint)")("joints", x.joints);
  io.about("Of the TCP of the tool, or else of the model's first reflector")("residual_mm", x.residual_mm);
  io("residual_deg", x.residual_deg);
  io("iterations", x.iterations, kCount);
  io.about("Orientation was given up next to the wrist singularity: axes 4 and 6 then turn less")("damped",
                                                                                                  x.damped);
}
void layout(Io& io, TargetsCompensate& x) {
  io.about(
        "Nominal joints, deg (mm for a prismatic joint): the real arm shall stand where the nominal one "
        "would")
      .optional("joints", x.joints, Size{1, 200});
  io.about("Flange, or where one is given the tool, in the robot base: x,y,z in mm, KUKA a,b,c in deg")
      .optional("poses", x.poses, Size{1, 200});
  io.about("Default: the active model").format("uuid").optional("model_id", x.model_id, kIdSize);
  io.about(
        "Number of a tool of the cell file: where it was measured, its TCP is corrected; where its load "
        "is known, the flange carries that")
      .optional("tool", x.tool, Whole{1, 1000});
  io.about(
        "What the flange carries: one row of kg, and x,y,z of its centre in the flange frame, mm. "
        "Default: the tool's load, or what it carried when it was measured")
      .optional("payload", x.payload, Size{1, 1});
}
void check(const Io& io, const TargetsCompensate& x) {
  if (!x.payload.empty() && x.payload.front()[0] < 0) io.fail_at("payload", "expected a mass of 0 or more");
}
const Method& TargetsCompensate::method() {
  static const Method kMethod{
      .name = "targets.compensate",
      .summary = "The joints to command for the real arm to stand at the target",
      .description =
          "Exactly one of joints and poses. An unreachable target is an error that names its row and why.",
      .errors = {ErrorCode::NotFound, ErrorCode::WrongState},
      .is_long = true,
  };
  return kMethod;
}

std::vector<Described> targets_methods() { return {described<TargetsCompensate>()}; }

}  // namespace truepose::rpc
