#include "daemon/control/session.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <utility>

#include "config/number_text.hpp"
#include "daemon/control/control_server.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/param_reader.hpp"
#include "proto/control/schema.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

using namespace asio::experimental::awaitable_operators;
using control::ErrorCode;
using control::ParamReader;
using control::Role;
using control::RpcError;

constexpr int kProtocol = 1;
constexpr const char* kTokenFile = "token file";  // whose token has no other name
constexpr std::size_t kEventsPerBatch = 64;
constexpr auto kNever = asio::steady_timer::time_point::max();

json::string_view view(std::string_view text) { return {text.data(), text.size()}; }

}  // namespace

const std::set<std::string, std::less<>>& Session::own_methods() {
  static const std::set<std::string, std::less<>> kMethods{
      "session.challenge",  "session.hello",    "system.info", "events.subscribe",
      "events.unsubscribe", "rpc.discover",     "control.get", "control.acquire",
      "control.release",    "control.takeover", "audit.list"};
  return kMethods;
}

void SessionContext::refresh_access() {
  const auto changed = access.refresh();
  if (!changed) parts.warn(changed.error());
  if (!changed.value_or(false)) return;
  const std::set<Session*> all = sessions;
  for (Session* session : all) session->check_access();
}

void SessionContext::warn_of_tls(const std::string& peer, const std::string& why) {
  if (parts.clock.now() < next_tls_warning) return;
  next_tls_warning = parts.clock.now() + limits.hello_window;
  parts.warn("control: no TLS with " + peer + ": " + why);
}

Session::Session(std::unique_ptr<Connection> connection, Peer peer, std::shared_ptr<SessionContext> context)
    : connection_{std::move(connection)},
      peer_{std::move(peer)},
      context_{std::move(context)},
      number_{++context_->last_number},
      wake_{connection_->executor(), kNever},
      drained_{connection_->executor(), kNever},
      lines_{control::kMaxLineBeforeHello},
      connected_{context_->parts.clock.now()},
      last_request_{connected_} {
  context_->sessions.insert(this);
}

Session::~Session() { context_->sessions.erase(this); }

void Session::start() {
  const auto done = [self = shared_from_this()](std::exception_ptr) { self->close(); };
  asio::co_spawn(connection_->executor(), read_requests(),
                 asio::bind_cancellation_slot(cancel_.slot(), done));
}

void Session::refuse(RpcError error) {
  dismiss(std::move(error));
  start();
}

void Session::stop() {
  close();
  cancel_.emit(asio::cancellation_type::terminal);
}

void Session::spawn_writer() {
  const auto done = [self = shared_from_this()](std::exception_ptr) {
    self->written_ = true;
    self->drained_.cancel();
  };
  asio::co_spawn(connection_->executor(), write_lines(), done);
}

void Session::close() {
  connection_->close();
  subscription_.reset();
  finishing_ = true;
  wake_.cancel();
  drained_.cancel();
}

void Session::send(std::string line) {
  outgoing_ += line;
  wake_.cancel();
}

void Session::dismiss(RpcError error) {
  send(control::encode_error({}, error));
  finishing_ = true;
}

// Reading.

asio::awaitable<bool> Session::open() {
  auto alarm = context_->parts.clock.sleep_until(connected_ + context_->limits.hello);
  auto outcome = co_await (connection_->open() || std::move(alarm));
  if (outcome.index() == 1) co_return false;
  auto& opened = std::get<0>(outcome);
  if (opened) certificate_ = *std::move(opened);
  if (!opened) context_->warn_of_tls(peer(), opened.error());
  co_return opened.has_value();
}

asio::awaitable<void> Session::read_requests() {
  if (!co_await open()) co_return;
  spawn_writer();
  while (!finishing_) {
    const std::optional<drivers::TimePoint> until = deadline();
    const std::size_t size = co_await read_some(until);
    if (size == 0) {
      if (until && context_->parts.clock.now() >= *until)
        dismiss({ErrorCode::InvalidRequest, !authenticated() ? "closed: no session.hello came in time"
                                            : line_started_.has_value()
                                                ? "closed: the line did not end in time"
                                                : "closed: nothing was asked for too long"});
      finishing_ = true;
      wake_.cancel();
      break;
    }
    lines_.push({input_.data(), size});
    while (!finishing_) {
      std::optional<std::string> line = lines_.next();
      if (!line) break;
      line_started_.reset();
      co_await serve(std::move(*line));
      last_request_ = context_->parts.clock.now();  // after it: a long call is no idleness
    }
    if (!lines_.partial()) {
      line_started_.reset();
    } else if (!line_started_) {
      line_started_ = context_->parts.clock.now();
    }
    if (!finishing_ && lines_.overflowed())
      dismiss({ErrorCode::InvalidRequest,
               "closed: a line was longer than " +
                   std::to_string(authenticated() ? control::kMaxLine : control::kMaxLineBeforeHello) +
                   " bytes"});
  }
  co_await discard_input();
}

// Closing a socket with unread input resets the connection: the client might never see what we sent last.
asio::awaitable<void> Session::discard_input() {
  const drivers::TimePoint until = context_->parts.clock.now() + context_->limits.farewell;
  std::size_t size = 1;
  while (size > 0 && context_->parts.clock.now() < until) size = co_await read_some(until);
  while (!written_) {
    const auto waited = co_await drained_.async_wait(asio::as_tuple(asio::use_awaitable));
    static_cast<void>(waited);
  }
}

std::optional<drivers::TimePoint> Session::deadline() const {
  const ControlLimits& limits = context_->limits;
  if (!authenticated()) return connected_ + limits.hello;
  if (line_started_) return *line_started_ + limits.line;
  if (subscription_) return std::nullopt;
  return last_request_ + limits.idle;
}

asio::awaitable<std::size_t> Session::read_some(std::optional<drivers::TimePoint> deadline) {
  auto reading = connection_->read_some(asio::buffer(input_));
  if (!deadline) {
    const std::size_t size = co_await std::move(reading);
    co_return size;
  }
  auto alarm = context_->parts.clock.sleep_until(*deadline);
  const auto outcome = co_await (std::move(reading) || std::move(alarm));
  co_return outcome.index() == 0 ? std::get<0>(outcome) : 0;
}

asio::awaitable<void> Session::serve(std::string line) {
  auto request = control::decode_request(line);
  if (!request) {
    send(control::encode_error(request.error().id, request.error().error));
    finishing_ = !authenticated();
    co_return;
  }
  // A notification has no answer, so nothing can be commanded by one.
  if (request->is_notification()) co_return;

  const control::Id id = request->id;
  Result result;
  if (authenticated()) {
    result = co_await call(std::move(*request));
  } else if (request->method == "session.hello") {
    result = co_await hello(std::move(request->params));
  } else if (request->method == "session.challenge") {
    result = challenge(request->params);
  } else {
    result = std::unexpected(RpcError{ErrorCode::Unauthenticated, "the first request must be session.hello"});
  }
  std::string reply =
      result ? control::encode_result(id, *result) : control::encode_error(id, result.error());
  if (reply.size() > control::kMaxLine + 1)
    reply = control::encode_error(
        id, {ErrorCode::Internal, "the answer has " + std::to_string(reply.size()) +
                                      " bytes, more than a line may have; ask for less"});
  send(std::move(reply));
  if (!authenticated() && !(result && request->method == "session.challenge")) finishing_ = true;
  // A client that asks without reading the answers waits, rather than filling our memory.
  while (!outgoing_.empty() && !finishing_) {
    const auto waited = co_await drained_.async_wait(asio::as_tuple(asio::use_awaitable));
    static_cast<void>(waited);
  }
}

asio::awaitable<Session::Result> Session::call(control::Request request) {
  if (request.method == "session.hello" || request.method == "session.challenge")
    co_return std::unexpected(RpcError{ErrorCode::InvalidRequest, "the session is open already"});
  if (auto refused = forbidden(request.method)) co_return std::unexpected(*refused);
  if (request.method == "system.info") co_return system_info(request.params);
  if (request.method == "events.subscribe") {
    Result subscribed = co_await subscribe(std::move(request.params));
    co_return subscribed;
  }
  if (request.method == "events.unsubscribe") co_return unsubscribe(request.params);
  if (request.method == "rpc.discover") co_return control::parse_json(control::openrpc_text()).value();
  if (request.method == "control.get") co_return context_->commands->who_has_control();
  if (request.method == "audit.list") {
    Result records = co_await context_->commands->records(std::move(request.params));
    co_return records;
  }
  const bool is_command = control::role_of(request.method).value_or(Role::Viewer) > Role::Viewer;
  if (is_command &&
      (own_methods().contains(request.method) || context_->cell_methods.contains(request.method))) {
    Result result = co_await context_->commands->carry_out(caller_, peer(), std::move(request));
    co_return result;
  }
  if (!context_->cell_methods.contains(request.method))
    co_return std::unexpected(
        RpcError{ErrorCode::MethodNotFound, "no method \"" + request.method.substr(0, 64) + "\""});

  Result result =
      co_await context_->commands->call_cell(std::move(request.method), std::move(request.params));
  co_return result;
}

// The server's own methods.

Session::Result Session::challenge(const json::object& params) {
  ParamReader read{params};
  if (auto error = read.finish()) return std::unexpected(*error);
  terms_ = {peer_.endpoint, {}, control::new_nonce()};
  return json::object{{"nonce", terms_.server_nonce}};
}

Session::Known Session::caller_of_token(const std::string& token) const {
  if (control::same_secret(token, context_->token)) return Caller{kTokenFile, Role::Admin};
  const control::AccessEntry* const entry = context_->access.entries().of_token(token);
  if (!entry)
    return std::unexpected(
        "wrong token: use the content of the daemon's token file, or what `truepose access add` printed");
  return Caller{.name = entry->name, .role = entry->role, .entry = *entry};
}

Session::Known Session::caller_of_certificate() const {
  const std::string fault = control::validity_fault(*certificate_, context_->parts.wall_clock());
  if (!fault.empty())
    return std::unexpected("the certificate of " + config::in_quotes(certificate_->name) + " " + fault);
  const control::AccessEntry* const entry =
      context_->access.entries().of_certificate(certificate_->fingerprint);
  if (!entry)
    return std::unexpected("nobody is known by the certificate " + certificate_->fingerprint +
                           "; let it in by `truepose access add NAME --certificate FILE`");
  return Caller{.name = entry->name, .role = entry->role, .entry = *entry};
}

Session::Known Session::caller_of(const std::optional<std::string>& token,
                                  const std::optional<std::string>& proof) const {
  if (token) return caller_of_token(*token);
  if (!proof && peer_.trusted) return Caller{peer_.name, Role::Admin};
  if (!proof) return caller_of_certificate();
  const bool asked = !terms_.server_nonce.empty();
  if (!asked ||
      !control::same_secret(*proof, session_proof(context_->token, control::Prover::Client, terms_)))
    return std::unexpected("wrong token: use the content of the daemon's token file");
  return Caller{kTokenFile, Role::Admin};
}

void Session::check_access() {
  if (!authenticated() || !caller_.entry) return;
  const control::AccessEntry* const now = context_->access.entries().named(caller_.name);
  if (now && *now == *caller_.entry) return;
  dismiss({ErrorCode::Unauthenticated, "closed: the access of " + caller_.name + " was changed or revoked"});
  connection_->end_reading();
}

std::optional<RpcError> Session::forbidden(const std::string& method) const {
  const std::optional<Role> least = control::role_of(method);
  if (!least || caller_.role >= *least) return std::nullopt;
  return RpcError{ErrorCode::Forbidden, method + " needs the role " + std::string{control::name(*least)} +
                                            "; " + caller_.name + " is " +
                                            std::string{control::name(caller_.role)}};
}

std::optional<RpcError> Session::no_room() const {
  std::size_t open = 0, of_peer = 0;
  for (const Session* session : context_->sessions) {
    if (session->stage() != Stage::Open) continue;
    ++open;
    if (session->peer() == peer()) ++of_peer;
  }
  if (open >= context_->limits.sessions)
    return RpcError{ErrorCode::Busy, "closed: " + std::to_string(open) + " sessions are open already"};
  if (of_peer >= context_->limits.of_one_peer)
    return RpcError{ErrorCode::Busy,
                    "closed: " + peer() + " has " + std::to_string(of_peer) + " sessions open already"};
  return std::nullopt;
}

asio::awaitable<Session::Result> Session::hello(json::object params) {
  ParamReader read{params};
  const auto protocol = read.required(read.integer("protocol", 0, 1'000'000), "protocol");
  const auto token = read.text("token", 2048);
  const auto nonce = read.text("nonce", 128);
  const auto proof = read.text("proof", 128);
  if (protocol != kProtocol)
    read.fail("protocol", "this daemon speaks protocol " + std::to_string(kProtocol));
  if (proof.has_value() != nonce.has_value()) read.fail("proof", "comes with a nonce, and a nonce with it");
  if (nonce && !control::is_nonce(*nonce)) read.fail("nonce", "is 32 digits, 0-9 and a-f");
  if (!token && !proof && !peer_.trusted && !certificate_) read.fail("token", "is missing");
  if (auto error = read.finish()) co_return std::unexpected(*error);
  terms_.client_nonce = nonce.value_or("");

  // Looked at before the delay, so that whoever knows the token is not driven out by the many that do not.
  context_->refresh_access();
  const auto caller = caller_of(token, proof);
  stage_ = caller ? Stage::Right : Stage::Wrong;
  auto& failures = context_->hello_failures[peer()];
  const drivers::TimePoint now = context_->parts.clock.now();
  while (!failures.empty() && now - failures.front() >= context_->limits.hello_window) failures.pop_front();
  const bool suspected = failures.size() >= context_->limits.hello_failures;
  if (stage_ == Stage::Wrong && !suspected) failures.push_back(now);
  if (suspected && !(peer_.trusted && stage_ == Stage::Right)) {
    const drivers::TimePoint then = now + context_->limits.hello_delay;
    co_await context_->parts.clock.sleep_until(then);
  }
  if (stage_ == Stage::Wrong) {
    if (!suspected)
      context_->parts.warn("control: a client (" + peer() + ") was not let in: " + caller.error());
    co_return std::unexpected(RpcError{ErrorCode::Unauthenticated, caller.error()});
  }
  if (auto error = no_room()) co_return std::unexpected(*error);
  stage_ = Stage::Open;
  caller_ = *caller;
  lines_.set_max_line(control::kMaxLine);
  json::object welcome{{"product", "trueposed"},
                       {"version", TRUEPOSE_VERSION},
                       {"protocol", kProtocol},
                       {"cell", context_->cell_name},
                       {"time", control::rfc3339(context_->parts.wall_clock())},
                       {"next_seq", context_->parts.events.next_seq()},
                       {"name", caller_.name},
                       {"role", view(control::name(caller_.role))}};
  if (proof) welcome["proof"] = session_proof(context_->token, control::Prover::Server, terms_);
  co_return welcome;
}

Session::Result Session::system_info(const json::object& params) const {
  ParamReader read{params};
  if (auto error = read.finish()) return std::unexpected(*error);
  const std::chrono::duration<double> uptime = context_->parts.clock.now() - context_->started;
  json::object info{{"product", "trueposed"},
                    {"version", TRUEPOSE_VERSION},
                    {"protocol", kProtocol},
                    {"cell", context_->cell_name},
                    {"time", control::rfc3339(context_->parts.wall_clock())},
                    {"started", context_->started_text},
                    {"uptime_s", uptime.count()},
                    {"connections", context_->sessions.size()}};
  if (context_->tls) {
    const control::Certificate& ours = context_->tls->certificate();
    info["tls"] = {{"fingerprint", ours.fingerprint}, {"valid_until", control::rfc3339(ours.until)}};
  }
  return info;
}

asio::awaitable<Session::Result> Session::subscribe(json::object params) {
  EventBus& events = context_->parts.events;
  ParamReader read{params};
  const auto names = read.texts("topics");
  const auto after = read.integer("after", 0, static_cast<std::int64_t>(events.next_seq()) - 1);
  std::set<control::Topic> topics;
  if (!names) {
    for (const auto& [name, topic] : control::kTopics) topics.insert(topic);
  }
  for (const std::string& name : names.value_or(std::vector<std::string>{})) {
    const auto topic = control::topic_from_name(name);
    if (topic) topics.insert(*topic);
    if (!topic) read.fail("topics", "no topic \"" + name + "\"");
  }
  if (auto error = read.finish()) co_return std::unexpected(*error);

  subscription_.reset();
  const std::uint64_t last_seen = after ? static_cast<std::uint64_t>(*after) : events.next_seq() - 1;
  auto gaps = co_await gaps_behind(last_seen);
  if (!gaps) co_return std::unexpected(RpcError{ErrorCode::Internal, gaps.error().detail});
  // Of one moment, from here on.
  const std::uint64_t next = events.next_seq();
  const std::uint64_t oldest = events.oldest_seq();
  const auto wake = [weak = weak_from_this(), executor = connection_->executor()] {
    asio::post(executor, [weak] {
      if (const auto self = weak.lock()) self->see_events();
    });
  };
  subscription_ = events.subscribe(topics, after ? last_seen : next - 1, wake);
  ++subscriptions_;
  json::array subscribed, missing;
  for (const control::Topic topic : topics) subscribed.emplace_back(view(control::name(topic)));
  for (const EventGap& gap : *gaps)
    missing.push_back(json::object{{"first", gap.first}, {"last", gap.last}, {"reason", gap.reason}});
  co_return json::object{{"topics", std::move(subscribed)},
                         {"next", next},
                         {"oldest", oldest},
                         {"complete", gaps->empty()},
                         {"missing", std::move(missing)}};
}

/// Numbers after `last_seen` of which something may be missing.
asio::awaitable<StoreResult<std::vector<EventGap>>> Session::gaps_behind(std::uint64_t last_seen) {
  const EventBus& events = context_->parts.events;
  const std::uint64_t first = last_seen + 1, oldest = events.oldest_seq();
  if (first >= oldest) co_return std::vector<EventGap>{};
  if (!events.archive()) co_return std::vector{EventGap{first, oldest - 1, "no longer kept"}};
  auto job = [archive = events.archive(), first, oldest] { return archive->event_gaps(first, oldest); };
  auto gaps = co_await context_->parts.worker.ask(job);
  const std::vector<EventGap> not_yet_told = events.unwritten(0).gaps;
  if (gaps) gaps->insert(gaps->end(), not_yet_told.begin(), not_yet_told.end());
  co_return gaps;
}

Session::Result Session::unsubscribe(const json::object& params) {
  ParamReader read{params};
  if (auto error = read.finish()) return std::unexpected(*error);
  subscription_.reset();
  return json::object{{"topics", json::array{}}};
}

// Not left to the writer, which may be stuck in a write to this very client.
void Session::see_events() {
  wake_.cancel();
  if (!subscription_ || !subscription_->fell_behind()) return;
  context_->parts.warn("control: a client read its events too slowly and was disconnected");
  close();
}

// Writing.

asio::awaitable<std::string> Session::next_batch() {
  std::string batch = std::exchange(outgoing_, {});
  if (!subscription_ || finishing_) co_return batch;
  if (batch.empty()) batch = co_await read_missed();
  if (!subscription_ || finishing_) co_return batch;
  for (const EventBus::Line& line : subscription_->take(kEventsPerBatch)) batch += *line;
  co_return batch;
}

/// What the subscription missed and the archive has: the next part of it, with replies that came meanwhile.
asio::awaitable<std::string> Session::read_missed() {
  std::string batch;
  while (batch.empty() && subscription_ && !finishing_) {
    const auto missed = subscription_->missed();
    if (!missed) break;
    const std::uint64_t subscription = subscriptions_;
    auto job = [archive = context_->parts.events.archive(), missed] {
      return archive->events(missed->topics, missed->first, missed->end);
    };
    auto page = co_await context_->parts.worker.ask(job);
    // By then it may be another's, or nobody's.
    if (!subscription_ || subscription != subscriptions_) break;
    if (!page) {
      context_->parts.warn("control: " + page.error().detail);
      dismiss({ErrorCode::Internal, "closed: what was missed cannot be read: " + page.error().detail});
      break;
    }
    subscription_->go_on_from(page->next);
    for (const KeptEvent& event : page->events)
      batch += control::encode_event_text(event.seq, event.time, event.topic, event.data);
  }
  co_return batch + std::exchange(outgoing_, {});
}

asio::awaitable<void> Session::write_lines() {
  while (true) {
    const std::string batch = co_await next_batch();
    if (batch.empty()) {
      if (finishing_) {
        auto farewell =
            context_->parts.clock.sleep_until(context_->parts.clock.now() + context_->limits.farewell);
        const auto said = co_await (connection_->end_writing() || std::move(farewell));
        static_cast<void>(said);
        co_return;  // the reader closes, once the client has had time to read
      }
      const auto waited = co_await wake_.async_wait(asio::as_tuple(asio::use_awaitable));
      static_cast<void>(waited);
      continue;
    }
    auto alarm =
        context_->parts.clock.sleep_until(context_->parts.clock.now() + context_->limits.write_stall);
    const auto outcome = co_await (connection_->write(asio::buffer(batch)) || std::move(alarm));
    if (outcome.index() == 1 || !std::get<0>(outcome)) break;
    drained_.cancel();
  }
  close();
}

}  // namespace truepose::daemon
