#include "proto/rpc/session.hpp"

#include "proto/control/session_proof.hpp"

namespace truepose::rpc {

using record::OneOf, record::Size, record::Whole;

namespace {

struct Nonce {
  std::string_view fault(const std::string& text) const {
    return control::is_nonce(text) ? "" : "is 32 digits, 0-9 and a-f";
  }
};

}  // namespace

void layout(Io& io, JobError& x) {
  io("code", x.code);
  io("message", x.message);
  io("data", x.data);
}
void layout(Io& io, Job& x) {
  io.record("Job");
  io.about("Its number")("id", x.id);
  io.about("That was called")("method", x.method);
  io("state", x.state, OneOf{"running", "done", "failed"});
  io.about("What the cell does meanwhile, or for what it waits: one sentence; empty once it has ended")(
      "doing", x.doing);
  io.about("When").format("date-time")("started", x.started);
  io.about("When; null while it runs").nullable("ended", x.ended);
  io.about("Of the method, once it is done; only in answers of job.get").optional("result", x.result);
  io.about("Of the method, where it failed").optional("error", x.error);
}

void layout(Io& io, AsJob& x) { io.defaulted("job", x.job); }
void layout(Io& io, JobBegun& x) { io("job", x.job); }

void layout(Io& io, Greeting::Protocol& x) {
  io("major", x.major);
  io("minor", x.minor);
}
void layout(Io& io, Greeting& x) {
  io("product", x.product);
  io("version", x.version);
  io("protocol", x.protocol);
  io("cell", x.cell);
  io("time", x.time);
  io("auth", x.auth);
}

void layout(Io& io, SessionChallenge::Result& x) {
  io.about("The server's nonce, 32 digits")("nonce", x.nonce);
}
const Method& SessionChallenge::method() {
  static const Method kMethod{
      .name = "session.challenge",
      .summary = "A nonce for a session.hello that proves to know the token without sending it",
      .description =
          "Before session.hello, on the same connection. A proof is the HMAC-SHA256 of five lines, keyed "
          "with the token; each line ends with a newline. The lines are: 'truepose session 1'; 'client'; "
          "the address and port that the client connected to ('127.0.0.1 7210'); the client's nonce; the "
          "server's nonce. The daemon's own proof, in the answer of session.hello, has 'server' in place "
          "of 'client'. Nonces and proofs are in lower-case hexadecimal digits.",
  };
  return kMethod;
}

void layout(Io& io, SessionHello::Result& x) {
  io("product", x.product, OneOf{"trueposed"});
  io.about("Of the program")("version", x.version);
  io("protocol", x.protocol, Whole{1, 1});
  io.about("Name of the cell")("cell", x.cell);
  io.about("Who the client is: of the access list, 'token file', or 'uid 1000' over the Unix socket")("name",
                                                                                                      x.name);
  io.about("It may call methods with this x-role or a lower one")("role", x.role, control::kRoles);
  io.about("The daemon's clock").format("date-time")("time", x.time);
  io.about("Number of the next event")("next_seq", x.next_seq);
  io.about("That the daemon knows the token; where the client has proved it").optional("proof", x.proof);
}
void layout(Io& io, SessionHello& x) {
  io.about("The version that the client speaks")("protocol", x.protocol, Whole{1, 1});
  io.about("Content of the token file, without the newline, or what `truepose access add` printed")
      .optional("token", x.token);
  io.about("The client's nonce, 32 digits, never used before").optional("nonce", x.nonce, Nonce{});
  io.about("That the client knows the token").optional("proof", x.proof);
  io.about(
        "Within so many seconds the client asks for something, session.ping at least; left out: 60, and "
        "no limit while events are subscribed to")
      .optional("heartbeat_s", x.heartbeat_s, Whole{5, 3600});
}
void check(const Io& io, const SessionHello& x) {
  if (x.proof.has_value() != x.nonce.has_value())
    io.fail_at("proof", "comes with a nonce, and a nonce with it");
}
const Method& SessionHello::method() {
  static const Method kMethod{
      .name = "session.hello",
      .summary = "Opens the session: the first request of every connection",
      .description =
          "Within 3 s after connecting. A session without requests for 60 s and without a subscription is "
          "closed. A session that names heartbeat_s is closed after so long without a request, subscribed "
          "or not. Three ways to authenticate: the token, or nonce and proof (session.challenge), or "
          "neither. Neither is enough over the Unix socket, and over TLS where the access list has the "
          "client's certificate. A token of the access list (`truepose access add`) is sent itself: the "
          "daemon keeps its hash alone. A refusal closes the connection, and so does a change of the "
          "client's access. After five wrong tokens within a minute a peer is answered a second late.",
      .errors = {ErrorCode::Unauthenticated, ErrorCode::Busy},
  };
  return kMethod;
}

void layout(Io& io, SessionPing::Result& x) {
  io.about("The daemon's clock").format("date-time")("time", x.time);
  io.about("Number of the next event")("next_seq", x.next_seq);
}
const Method& SessionPing::method() {
  static const Method kMethod{
      .name = "session.ping",
      .summary = "Says that the client is there, and sees that the daemon is",
      .errors = {ErrorCode::Unauthenticated},
  };
  return kMethod;
}

void layout(Io& io, TlsCertificate& x) {
  io.about("SHA-256")("fingerprint", x.fingerprint);
  io.format("date-time")("valid_until", x.valid_until);
}
void layout(Io& io, SystemInfo::Result& x) {
  io("product", x.product);
  io("version", x.version);
  io("protocol", x.protocol);
  io("cell", x.cell);
  io.about("The daemon's clock").format("date-time")("time", x.time);
  io.about("When the daemon started").format("date-time")("started", x.started);
  io("uptime_s", x.uptime_s);
  io.about("Open control connections")("connections", x.connections);
  io.about("The daemon's certificate; where it listens for other machines").optional("tls", x.tls);
}
const Method& SystemInfo::method() {
  static const Method kMethod{
      .name = "system.info",
      .summary = "Versions and uptime",
  };
  return kMethod;
}

void layout(Io& io, JobGet& x) { io.about("What the call was answered with")("id", x.id, kIdSize); }
const Method& JobGet::method() {
  static const Method kMethod{
      .name = "job.get",
      .summary = "Progress or result of a call that was made as a job",
      .description =
          "Of the client's own jobs (by its name, not its connection). Those that ended are kept for ten "
          "minutes.",
      .errors = {ErrorCode::Unauthenticated, ErrorCode::InvalidParams, ErrorCode::NotFound},
  };
  return kMethod;
}

void layout(Io& io, Discover& x) { io.optional("method", x.of_method); }
const Method& Discover::method() {
  static const Method kMethod{
      .name = "rpc.discover",
      .summary = "The schema in outline, or one method of it in full",
  };
  return kMethod;
}

std::vector<Described> session_methods() {
  return {described<SessionChallenge>(), described<SessionHello>(), described<SessionPing>(),
          described<SystemInfo>(), described<JobGet>()};
}

}  // namespace truepose::rpc
