#include "proto/rpc/cell.hpp"

namespace truepose::rpc {

using record::OneOf;

void layout(Io& io, RobotStatus& x) {
  io.record("RobotStatus");
  io("connected", x.connected);
  io.about("The controller's own name of the arm; empty while unknown")("model", x.model);
  io("serial", x.serial);
  io("software", x.software);
  io.about("May be moved")("ready", x.ready);
  io.about("One phrase where ready is false, else empty")("why_not_ready", x.why_not_ready);
  io.about("Actual axes in deg (mm for a prismatic joint); empty while unknown")("q_deg", x.q_deg);
}

void layout(Io& io, TrackerStatus& x) {
  io.record("TrackerStatus");
  io("connected", x.connected);
  io("model", x.model);
  io("serial", x.serial);
  io("firmware", x.firmware);
  io.about("One phrase while not connected, else empty")("why_not_ready", x.why_not_ready);
}

void layout_members(Io& io, Fault& x) {
  io.about("Stable name, e.g. E_BEAM_BROKEN")("code", x.code);
  io("severity", x.severity, OneOf{"warning", "error"});
  io.about("One sentence for the operator")("text", x.text);
  io.about("When it came").format("date-time")("since", x.since);
}
void layout(Io& io, Fault& x) {
  io.record("Fault");
  layout_members(io, x);
}

void layout(Io& io, AwaitedDevice& x) {
  io("device", x.device, OneOf{"controller", "tracker"});
  io.format("date-time")("since", x.since);
  io.about("What it has to do, or what has happened to it")("reason", x.reason);
}
void layout(Io& io, CellStatus::Recording& x) {
  io.about("From its oldest record to its newest")("seconds", x.seconds);
  io.about("That it takes")("bytes", x.bytes);
  io.about("Records for which there was no room")("dropped", x.dropped);
  io.about("Recording that this daemon wrote last").nullable("last", x.last);
}
void layout(Io& io, CellStatus& x) {
  io.record("CellStatus");
  io.about("Name of the cell")("cell", x.cell);
  io.about("What the cell does")(
      "state", x.state,
      OneOf{"disconnected", "connecting", "ready", "campaign", "paused", "streaming", "armed", "fault"});
  io.about("One sentence for the operator")("state_text", x.state_text);
  io.about("What an operator does next, in one sentence").optional("next", x.next);
  io.about("Methods that this state allows")("allowed", x.allowed);
  io.about("The device that has to answer before the cell continues").nullable("waiting", x.waiting);
  io.about("The daemon's clock").format("date-time")("time", x.time);
  io("robot", x.robot);
  io("tracker", x.tracker);
  io.nullable("campaign", x.campaign);
  io.about("Campaigns that can be resumed, the newest first")("interrupted", x.interrupted);
  io.nullable("model", x.model);
  io("stream", x.stream);
  io.about("What is kept of the last minutes on the wires")("recording", x.recording);
  io.about("Those that stand, newest first")("faults", x.faults);
}

void layout(Io& io, SystemConfig::Result& x) { io.about("Files, and HOST:PORT")("config", x.config); }
const Method& SystemConfig::method() {
  static const Method kMethod{
      .name = "system.config",
      .summary = "The configuration in use, without secrets",
  };
  return kMethod;
}

const Method& GetCellStatus::method() {
  static const Method kMethod{
      .name = "cell.status",
      .summary = "What the cell does, its devices, model, stream and faults",
  };
  return kMethod;
}

const Method& CellConnect::method() {
  static const Method kMethod{
      .name = "cell.connect",
      .role = Role::Operator,
      .summary = "Connects robot and tracker and checks that it is the right arm",
      .description = "Answers when both are connected, which may take a minute.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::WrongState, ErrorCode::Device,
                 ErrorCode::Busy, ErrorCode::Store},
      .is_long = true,
  };
  return kMethod;
}

const Method& CellDisconnect::method() {
  static const Method kMethod{
      .name = "cell.disconnect",
      .role = Role::Operator,
      .summary = "Releases robot and tracker",
      .errors = {ErrorCode::Forbidden, ErrorCode::WrongState},
      .is_always_carried_out = true,
  };
  return kMethod;
}

const Method& CellAcknowledge::method() {
  static const Method kMethod{
      .name = "cell.acknowledge",
      .role = Role::Operator,
      .summary = "Clears faults once their cause is gone",
      .description =
          "Where E_STREAM_FROZEN stands, in any state, the stream resumes from the correction that it "
          "holds. Where E_STORE stands, the store is tried: opened again if its disk has failed, and "
          "written to.",
      .errors = {ErrorCode::Forbidden, ErrorCode::WrongState, ErrorCode::Store},
      .is_always_carried_out = true,
  };
  return kMethod;
}

std::vector<Described> cell_methods() {
  return {described<SystemConfig>(), described<GetCellStatus>(), described<CellConnect>(),
          described<CellDisconnect>(), described<CellAcknowledge>()};
}

}  // namespace truepose::rpc
