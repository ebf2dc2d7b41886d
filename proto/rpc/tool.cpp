#include "proto/rpc/tool.hpp"

namespace truepose::rpc {

using record::kCount, record::Whole;

void layout(Io& io, ToolInUse& x) {
  io.record("ToolInUse");
  io.about("In TOOL_DATA")("number", x.number, kCount);
  io.about("The controller's TOOL_DATA; null: the tool is refused").nullable("krl", x.krl);
  io.about("Why nothing is corrected while this tool is in use; absent: it can be used")
      .optional("refused", x.refused);
  io.about("That measured it; null: it is of the cell file")
      .format("uuid")
      .nullable("campaign_id", x.campaign_id);
  io.about("When that ended").nullable("measured", x.measured);
}

void layout(Io& io, ToolList::Result& x) { io("tools", x.tools); }
const Method& ToolList::method() {
  static const Method kMethod{
      .name = "tool.list",
      .summary = "The measured tools that are known by their numbers",
  };
  return kMethod;
}

void layout(Io& io, ToolActivate& x) {
  io.about("The campaign of kind tool").format("uuid")("id", x.id, kIdSize);
}
const Method& ToolActivate::method() {
  static const Method kMethod{
      .name = "tool.activate",
      .role = Role::Engineer,
      .summary = "Takes the tool that a campaign measured into use, under its number",
      .description =
          "From then on the stream and targets.compensate correct that tool where it is in use, before one "
          "of the cell file. Refused where the readings contradict each other or the model. Refused too "
          "where the record is not the stored one (SHA-256), or the tool was measured on another arm. "
          "stream.start and stream.arm are refused while a tool in use is refused. Write krl into the "
          "TOOL_DATA of the controller: the daemon does not.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::NotFound, ErrorCode::WrongState,
                 ErrorCode::Store},
  };
  return kMethod;
}

void layout(Io& io, ToolDeactivate::Result& x) {
  io.about("The campaign that measured it").format("uuid")("deactivated", x.deactivated);
}
void layout(Io& io, ToolDeactivate& x) { io.about("In TOOL_DATA")("number", x.number, Whole{1, 1000}); }
const Method& ToolDeactivate::method() {
  static const Method kMethod{
      .name = "tool.deactivate",
      .role = Role::Engineer,
      .summary = "Takes a tool out of use that a campaign has measured; one of the cell file stays",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::NotFound, ErrorCode::Store},
  };
  return kMethod;
}

std::vector<Described> tool_methods() {
  return {described<ToolList>(), described<ToolActivate>(), described<ToolDeactivate>()};
}

}  // namespace truepose::rpc
