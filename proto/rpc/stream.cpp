#include "proto/rpc/stream.hpp"

namespace truepose::rpc {

using record::kCount, record::kLargeCount, record::OneOf;

namespace {

/// How stream.stop and stream.disarm end.
constexpr std::string_view kRampedOut =
    "Answers when the correction is zero. A frozen stream (E_STREAM_FROZEN) cannot be ramped out: it "
    "is refused at once (-32003), and the correction stays as it is. Remove the cause that the fault "
    "names, cell.acknowledge, and ask again. Or end the robot program on the pendant: its RSI takes "
    "the correction with it. A ramp that takes longer than 30 s is answered -32005, and is a fault "
    "of the cell.";

}  // namespace

void layout(Io& io, Percentiles& x) {
  io.record("Percentiles");
  io("p50", x.p50);
  io("p99", x.p99);
  io("p999", x.p999);
  io("max", x.max);
}

void layout(Io& io, StreamStatus::Tool& x) {
  io.about(
        "In TOOL_DATA, by the cell file or as the controller names it; null where it is not known or "
        "none is in use")
      .nullable("number", x.number, kCount);
  io.about("Whether its TCP is corrected; else the accuracy holds for the reflector")("measured", x.measured);
}
void layout(Io& io, StreamStatus::Robot& x) {
  io.nullable("mode", x.mode, OneOf{"T1", "T2", "AUT", "EXT"});
  io.nullable("override_percent", x.override_percent);
  io.about("Of the robot interpreter")
      .nullable("program", x.program, OneOf{"free", "reset", "active", "stopped", "ended"});
  io.nullable("emergency_stop", x.emergency_stop);
  io.about("The operator safety; matters in AUT and EXT").nullable("gate_open", x.gate_open);
  io.about("$TOOL in use: X, Y, Z in mm, A, B, C in deg").nullable("tool_frame", x.tool_frame);
  io.about("$BASE, likewise").nullable("base_frame", x.base_frame);
  io.about("$LOAD.M").nullable("load_kg", x.load_kg);
  io.about("Why something is not known, else empty")("unknown", x.unknown);
}
void layout(Io& io, StreamStatus::Arm& x) {
  io.about("Of the model's arm; null: no model is active").nullable("serial", x.serial);
  io("verified", x.verified);
  io.about("And how to verify it; empty: it is, or no model is active")("why_not", x.why_not);
}
void layout(Io& io, StreamStatus::LateBy& x) {
  io.about("The reply took long to compute")("daemon", x.daemon);
  io.about("The thread was woken late, kept from running, or waited for the socket")("machine", x.machine);
  io.about("The packet came late against the controller's IPOC")("network", x.network);
}
void layout(Io& io, StreamStatus::LastMinute& x) {
  io.about("Replies")("answered", x.answered);
  io.about("That the controller did not have in time")("late", x.late);
  io("daemon", x.daemon);
  io("machine", x.machine);
  io("network", x.network);
}
void layout(Io& io, StreamScheduling& x) {
  io.about("SCHED_FIFO, SCHED_OTHER")("policy", x.policy);
  io.about("0 under ordinary scheduling")("priority", x.priority, kCount);
  io.about("Where it may run")("cpus", x.cpus, kCount);
  io.about("Memory of the daemon that cannot be swapped out")("locked_kB", x.locked_kB);
}
void layout(Io& io, StreamStatus& x) {
  io.record("StreamStatus");
  io.about(
      "waiting: no packet, none that can be answered yet, or no model; ramping: in or out; holding: "
      "the last correction is kept")("state", x.state,
                                     OneOf{"off", "waiting", "ramping", "correcting", "holding", "fault"});
  io.about("Whether every session is corrected that a program of the arm opens")("armed", x.armed);
  io.about("Why it waits, holds, failed or ended, else empty")("reason", x.reason);
  io.about("The model in use").nullable("model_id", x.model_id);
  io.about("The tool that is corrected")("tool", x.tool);
  io.about("State of the controller; null where it is not known")("robot", x.robot);
  io.about(
      "Arm of the active model, and whether the corrected arm is known to be it. Known by the "
      "connection, or, of an armed stream, by its state server (CellState). Another arm's number ends "
      "an armed stream with a fault. After a reconnection the stream waits for the state server's "
      "number where it has sent one before (E_ARM)")("arm", x.arm);
  io.about("Address and port from which the controller sends").nullable("peer", x.peer);
  io.about("Of the controller's last good packet").nullable("packet_age_ms", x.packet_age_ms, kLargeCount);
  io.about("By which its IPOC rises from packet to packet").nullable("ipoc_step", x.ipoc_step);
  io.about("Of the controller, since the daemon was started")("sessions", x.sessions);
  io.about(
      "Packets received from the controller: each is in one of answered, wrong_ipoc, unconfirmed and, "
      "of those malformed, unanswered")("cycles", x.cycles);
  io.about("Replies sent")("answered", x.answered);
  io.about("Of these, with the last correction, because the packet, the model or a fault forbade another")(
      "held", x.held);
  io.about("Of these, the same reply to a repeated packet")("duplicate", x.duplicate);
  io.about("Not answered, because the correction in effect was not known; some at the start of each session")(
      "unconfirmed", x.unconfirmed);
  io.about("Packets that could not be believed")("malformed", x.malformed);
  io.about("Packets with an element that could not be read and is not what is corrected by")("partly_read",
                                                                                             x.partly_read);
  io.about("Packets of others than the controller, dropped; in no other figure")("unexpected_sender",
                                                                                 x.unexpected_sender);
  io.about("The last packet that was not taken: from where, why, how it begins")
      .nullable("refused", x.refused);
  io.about("Replies that were sent and that the controller did not have in time (its Delay)")("late", x.late);
  io.about("Packets missing in the controller's numbering")("lost", x.lost);
  io.about(
      "Packets out of order, by their IPOC, or repeated ones after a restart of the daemon; not "
      "answered")("wrong_ipoc", x.wrong_ipoc);
  io.about("Cycles in which a bound was reached")("clamped", x.clamped);
  io.about(
      "Cycles in which the calibrated arm was not inverted in eight steps, or not near: the "
      "correction was held")("no_solution", x.no_solution);
  io.about("Cycles that gave up orientation next to the wrist singularity")("damped", x.damped);
  io.about("Largest step of a correction sent")("max_step_deg", x.max_step_deg);
  io.about("Correction sent, per axis; empty while off")("correction_deg", x.correction_deg);
  io.about(
      "What AIPos - ASPos shows of it over the last second, lag and motion taken out; null where it "
      "is not identifiable; empty while off")("measured_deg", x.measured_deg);
  io.about(
      "Replies that left more than half a cycle after their packet was due, by the part with the "
      "greatest share of the delay")("late_by", x.late_by);
  io.about(
      "Of the replies within the last minute, those that were late: with the controller (Delay), and "
      "as late_by")("last_minute", x.last_minute);
  io.about("On the wire: from the kernel's receipt of a packet until its answer was sent, us")(
      "turnaround_us", x.turnaround_us);
  io.about("Of this, from the packet in hand until its answer was ready, us")("compute_us", x.compute_us);
  io.about("How the realtime thread runs now, from the kernel; null where there is none")
      .nullable("scheduling", x.scheduling);
}

const Method& StreamStart::method() {
  static const Method kMethod{
      .name = "stream.start",
      .role = Role::Operator,
      .summary = "Starts correcting over RSI with the active model",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::WrongState, ErrorCode::Device,
                 ErrorCode::Busy, ErrorCode::Store},
      .is_long = true,
  };
  return kMethod;
}

const Method& StreamStop::method() {
  static const Method kMethod{
      .name = "stream.stop",
      .role = Role::Operator,
      .summary = "Ramps the corrections out and leaves RSI",
      .description = kRampedOut,
      .errors = {ErrorCode::Forbidden, ErrorCode::WrongState, ErrorCode::Device},
      .is_always_carried_out = true,
      .is_long = true,
  };
  return kMethod;
}

const Method& StreamArm::method() {
  static const Method kMethod{
      .name = "stream.arm",
      .role = Role::Operator,
      .summary = "Corrects every program of the arm that opens RSI, from now on",
      .description =
          "Needs neither EKI nor tracker; their connections are closed. Stays over restarts of programs, "
          "controller and daemon, until stream.disarm or a fault.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl, ErrorCode::WrongState, ErrorCode::Store},
  };
  return kMethod;
}

const Method& StreamDisarm::method() {
  static const Method kMethod{
      .name = "stream.disarm",
      .role = Role::Operator,
      .summary = "Ramps the correction of the session that is open out, and corrects no other",
      .description = kRampedOut,
      .errors = {ErrorCode::Forbidden, ErrorCode::WrongState, ErrorCode::Device},
      .is_always_carried_out = true,
      .is_long = true,
  };
  return kMethod;
}

const Method& GetStreamStatus::method() {
  static const Method kMethod{
      .name = "stream.status",
      .summary = "Counters of the stream",
  };
  return kMethod;
}

std::vector<Described> stream_methods() {
  return {described<StreamStart>(), described<StreamStop>(), described<StreamArm>(),
          described<StreamDisarm>(), described<GetStreamStatus>()};
}

}  // namespace truepose::rpc
