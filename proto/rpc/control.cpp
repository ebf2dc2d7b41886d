#include "proto/rpc/control.hpp"

#include "proto/text/device_text.hpp"

namespace truepose::rpc {

using record::kLargeCount, record::Size, record::Whole;

namespace {

struct PersonName {
  std::string_view fault(const std::string& name) const {
    return text::device_text(name) == name ? "" : "expected your name";
  }
};

}  // namespace

void layout(Io& io, Control& x) {
  io.record("Control");
  io.about("The client that has control; null: none").nullable("holder", x.holder);
  io.optional("role", x.role, control::kRoles);
  io.about("Until it ends unless it is renewed").optional("left_s", x.left_s, kLargeCount);
}

void layout(Io& io, CommandId& x) { io.optional("command_id", x.command_id, Size{1, 64}); }

void layout(Io& io, AuditRecord& x) {
  io.record("AuditRecord",
            "A command before it is carried out (who, role, from, method, params), or what became of it "
            "(of, result)");
  io.about("Number, from 1")("n", x.n);
  io.about("SHA-256 of the record before, as a line of the file")("before", x.before);
  io.format("date-time")("time", x.time);
  io.optional("who", x.who);
  io.optional("role", x.role);
  io.about("Address, or user over the Unix socket").optional("from", x.from);
  io.optional("method", x.method);
  io.about("Above 4096 bytes their number and SHA-256").optional("params", x.params);
  io.about(
        "It was carried out while the disk took nothing, and was written down later; its time is when "
        "it came")
      .optional("written_later", x.written_later);
  io.about("Entries lost because the memory for unwritten ones was full").optional("missed", x.missed);
  io.about("Number of the command").optional("of", x.of);
  io.about("ok, or the error's code (E_STATE)").optional("result", x.result);
  io.about("Of the error").optional("message", x.message);
  io.about("That the command was given").optional("command_id", x.command_id);
  io.about(
        "To a command with a command_id, where it has no more than 4096 bytes: it is answered again to "
        "a replayed command after a restart of the daemon")
      .optional("answer", x.answer);
  io.about("Why what stood before this record was put aside, until audit.acknowledge the fault E_AUDIT")
      .optional("put_aside", x.put_aside);
}

const Method& ControlGet::method() {
  static const Method kMethod{
      .name = "control.get",
      .summary = "Who is in command",
  };
  return kMethod;
}

void layout(Io& io, ControlAcquire& x) {
  io.about("Seconds until it ends unless it is renewed; default 30")
      .optional("lease_s", x.lease_s, Whole{5, 60});
}
const Method& ControlAcquire::method() {
  static const Method kMethod{
      .name = "control.acquire",
      .role = Role::Operator,
      .summary = "Takes control, or renews it",
      .description =
          "While a client has control, commands of others (x-role above viewer) are answered with -32008, "
          "except those with x-always. What takes motion, a correction or control away needs the role "
          "alone. While no client has control, commands of every role are carried out. Control belongs to "
          "a name: a panel that reconnects within 10 s has it still. It is lost in three cases: not "
          "renewed in time; 10 s after its holder's last connection; access of its holder changed or "
          "revoked. The campaign under way is then paused, and the stream stays as it is. The audit log "
          "has changes of control, not its renewals.",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl},
      .is_always_carried_out = true,
  };
  return kMethod;
}

const Method& ControlTakeover::method() {
  static const Method kMethod{
      .name = "control.takeover",
      .role = Role::Operator,
      .summary = "Takes control from a lower role too",
      .errors = {ErrorCode::Forbidden, ErrorCode::NotInControl},
      .is_always_carried_out = true,
  };
  return kMethod;
}

const Method& ControlRelease::method() {
  static const Method kMethod{
      .name = "control.release",
      .role = Role::Operator,
      .summary = "Gives control back",
      .errors = {ErrorCode::Forbidden},
      .is_always_carried_out = true,
  };
  return kMethod;
}

void layout(Io& io, AuditList::Result& x) { io("records", x.records); }
void layout(Io& io, AuditList& x) {
  io.about("Only records with lower numbers").optional("before", x.before, Whole{1, kLargeCount.max});
  io.about("So many at most, and fewer where they are long; default 50")
      .optional("limit", x.limit, Whole{1, 200});
}
const Method& AuditList::method() {
  static const Method kMethod{
      .name = "audit.list",
      .summary = "What was commanded, newest first",
  };
  return kMethod;
}

void layout(Io& io, AuditAcknowledge::Result& x) {
  io.about("What was, one phrase")("acknowledged", x.acknowledged);
}
void layout(Io& io, AuditAcknowledge& x) {
  io.about("Of the person who has found out what happened, at most 64 bytes")("name", x.name, PersonName{},
                                                                              Size{1, 64});
}
const Method& AuditAcknowledge::method() {
  static const Method kMethod{
      .name = "audit.acknowledge",
      .role = Role::Admin,
      .summary = "Acknowledges that the audit trail was changed",
      .description =
          "Of the fault E_AUDIT, or of files of the audit log that were deleted, moved away, replaced or "
          "cut under the daemon: these are put back first. The audit log has the acknowledger's name; "
          "until then `truepose audit verify` ends with 1.",
      .errors = {ErrorCode::Forbidden, ErrorCode::WrongState, ErrorCode::Store},
      .is_always_carried_out = true,
  };
  return kMethod;
}

std::vector<Described> control_methods() {
  return {described<ControlGet>(),     described<ControlAcquire>(), described<ControlTakeover>(),
          described<ControlRelease>(), described<AuditList>(),      described<AuditAcknowledge>()};
}

}  // namespace truepose::rpc
