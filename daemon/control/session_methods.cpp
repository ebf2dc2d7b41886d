#include <boost/asio/post.hpp>
#include <utility>

#include "daemon/control/session.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/param_reader.hpp"
#include "proto/control/schema.hpp"

// What a session answers itself, and whom it asks for the rest.

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

using control::ErrorCode;
using control::ParamReader;
using control::Role;
using control::RpcError;

constexpr int kProtocol = 1;
constexpr int kProtocolMinor = 1;  // rises with each addition

json::string_view view(std::string_view text) { return {text.data(), text.size()}; }

bool is_command(const control::Request& request) {
  return control::role_of(request.method).value_or(Role::Viewer) > Role::Viewer;
}

/// Takes the member `job` away, since no method knows it.
std::expected<bool, RpcError> take_job(json::object& params) {
  const json::value* const given = params.if_contains("job");
  if (!given) return false;
  if (!given->is_bool())
    return std::unexpected(
        RpcError{ErrorCode::InvalidParams, "params.job: expected true or false", "params.job"});
  const bool job = given->get_bool();
  params.erase("job");
  return job;
}

/// The schema: an outline of all, or one method in full.
Session::Result discover(const json::object& params) {
  ParamReader read{params};
  const auto method = read.text("method");
  if (auto error = read.finish()) return std::unexpected(*error);
  if (!method) return control::openrpc_outline();
  const json::value* const found = control::openrpc_method(*method);
  if (found) return *found;
  return std::unexpected(RpcError{ErrorCode::NotFound, "the schema has no method \"" + *method + "\""});
}

/// Has the cell carry out a call, whether or not the session that it came from is still there.
asio::awaitable<Session::Result> ask_cell(std::shared_ptr<SessionContext> context, Caller caller,
                                          std::string from, control::Request request) {
  if (is_command(request)) {
    Session::Result result =
        co_await context->commands->carry_out(std::move(caller), std::move(from), std::move(request));
    co_return result;
  }
  Session::Result result = co_await context->commands->call_cell(
      std::move(request.method), std::move(request.params), std::move(caller.name));
  co_return result;
}

}  // namespace

const std::set<std::string, std::less<>>& Session::own_methods() {
  static const std::set<std::string, std::less<>> kMethods{
      "session.challenge",  "session.hello", "session.ping",      "system.info",     "events.subscribe",
      "events.unsubscribe", "rpc.discover",  "control.get",       "control.acquire", "control.release",
      "control.takeover",   "audit.list",    "audit.acknowledge", "job.get"};
  return kMethods;
}

void Session::greet() {
  json::array ways{"token", "proof"};
  if (certificate_) ways.emplace_back("certificate");
  if (peer_.trusted) ways.emplace_back("none");
  send(control::encode_notification("greeting",
                                    {{"product", "trueposed"},
                                     {"version", TRUEPOSE_VERSION},
                                     {"protocol", {{"major", kProtocol}, {"minor", kProtocolMinor}}},
                                     {"cell", context_->cell_name},
                                     {"time", control::rfc3339(context_->parts.wall_clock())},
                                     {"auth", std::move(ways)}}));
}

asio::awaitable<Session::Result> Session::call(control::Request request) {
  if (request.method == "session.hello" || request.method == "session.challenge")
    co_return std::unexpected(RpcError{ErrorCode::InvalidRequest, "the session is open already"});
  if (auto refused = forbidden(request.method)) co_return std::unexpected(*refused);
  if (request.method == "session.ping") co_return ping(request.params);
  if (request.method == "system.info") co_return system_info(request.params);
  if (request.method == "events.subscribe") {
    Result subscribed = co_await subscribe(std::move(request.params));
    co_return subscribed;
  }
  if (request.method == "events.unsubscribe") co_return unsubscribe(request.params);
  if (request.method == "rpc.discover") co_return discover(request.params);
  if (request.method == "control.get") co_return context_->commands->who_has_control(request.params);
  if (request.method == "job.get") co_return job(request.params);
  if (request.method == "audit.list") {
    Result records = co_await context_->commands->records(std::move(request.params));
    co_return records;
  }
  if (own_methods().contains(request.method)) {
    Result result = co_await context_->commands->carry_out(caller_, peer(), std::move(request));
    co_return result;
  }
  if (!context_->cell_methods.contains(request.method))
    co_return std::unexpected(
        RpcError{ErrorCode::MethodNotFound, "no method \"" + request.method.substr(0, 64) + "\""});
  const auto as_job = take_job(request.params);
  if (!as_job) co_return std::unexpected(as_job.error());
  if (*as_job) co_return begin_job(std::move(request));
  Result result = co_await ask_cell(context_, caller_, peer(), std::move(request));
  co_return result;
}

// Jobs.

Session::Result Session::begin_job(control::Request request) {
  std::string method = request.method;
  Jobs::Call call = [context = context_, caller = caller_, from = peer(),
                     request = std::move(request)]() -> asio::awaitable<Result> {
    return ask_cell(context, caller, from, request);
  };
  Jobs::Tell tell = [weak = weak_from_this()](const json::object& job) {
    const auto self = weak.lock();
    if (self && !self->finishing_) self->send(control::encode_notification("job", job));
  };
  auto id = context_->jobs->begin(std::move(method), caller_.name, std::move(call), std::move(tell));
  if (!id) return std::unexpected(id.error());
  return json::object{{"job", *id}};
}

Session::Result Session::job(const json::object& params) const {
  ParamReader read{params};
  const std::string id = read.required(read.id("id"), "id");
  if (auto error = read.finish()) return std::unexpected(*error);
  auto known = context_->jobs->find(id, caller_.name);
  if (known) return *std::move(known);
  return std::unexpected(RpcError{
      ErrorCode::NotFound, "no such job of " + caller_.name + "; ended ones are kept for ten minutes"});
}

// Hello.

Session::Result Session::challenge(const json::object& params) {
  ParamReader read{params};
  if (auto error = read.finish()) return std::unexpected(*error);
  terms_ = {peer_.endpoint, {}, control::new_nonce()};
  return json::object{{"nonce", terms_.server_nonce}};
}

Admission::Known Session::caller_of(const std::optional<std::string>& token,
                                    const std::optional<std::string>& proof) const {
  if (token) return context_->admission->by_token(*token);
  if (proof) return context_->admission->by_proof(*proof, terms_);
  if (peer_.trusted) return Caller{peer_.name, Role::Admin};
  return context_->admission->by_certificate(*certificate_);
}

void Session::check_access() {
  if (!authenticated() || context_->admission->still_known(caller_)) return;
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
  const auto heartbeat_s = read.integer("heartbeat_s", 5, 3600);
  if (protocol != kProtocol)
    read.fail("protocol", "this daemon speaks protocol " + std::to_string(kProtocol));
  if (proof.has_value() != nonce.has_value()) read.fail("proof", "comes with a nonce, and a nonce with it");
  if (nonce && !control::is_nonce(*nonce)) read.fail("nonce", "is 32 digits, 0-9 and a-f");
  if (!token && !proof && !peer_.trusted && !certificate_) read.fail("token", "is missing");
  if (auto error = read.finish()) co_return std::unexpected(*error);
  terms_.client_nonce = nonce.value_or("");

  // Checked before the delay: clients without the token must not keep out a client with it.
  context_->refresh_access();
  auto attempt = caller_of(token, proof);
  stage_ = attempt ? Stage::Right : Stage::Wrong;
  const auto caller = co_await context_->admission->judge(peer(), std::move(attempt), peer_.trusted);
  if (!caller) co_return std::unexpected(RpcError{ErrorCode::Unauthenticated, caller.error()});
  if (auto error = no_room()) co_return std::unexpected(*error);
  stage_ = Stage::Open;
  caller_ = *caller;
  context_->commands->see_connections();
  if (heartbeat_s) heartbeat_ = std::chrono::seconds{*heartbeat_s};
  lines_.set_max_line(control::kMaxLine);
  json::object welcome{{"product", "trueposed"},
                       {"version", TRUEPOSE_VERSION},
                       {"protocol", kProtocol},
                       {"cell", context_->cell_name},
                       {"time", control::rfc3339(context_->parts.wall_clock())},
                       {"next_seq", context_->parts.events.next_seq()},
                       {"name", caller_.name},
                       {"role", view(control::name(caller_.role))}};
  if (proof) welcome["proof"] = context_->admission->proof(terms_);
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
  if (!events.archive()) co_return std::vector{EventGap{first, oldest - 1, "not kept any more"}};
  auto job = [archive = events.archive(), first, oldest] { return archive->event_gaps(first, oldest); };
  auto gaps = co_await context_->parts.worker.ask(job);
  const std::vector<EventGap> not_yet_told = events.unwritten(0).gaps;
  if (gaps) gaps->insert(gaps->end(), not_yet_told.begin(), not_yet_told.end());
  co_return gaps;
}

Session::Result Session::ping(const json::object& params) const {
  ParamReader read{params};
  if (auto error = read.finish()) return std::unexpected(*error);
  return json::object{{"time", control::rfc3339(context_->parts.wall_clock())},
                      {"next_seq", context_->parts.events.next_seq()}};
}

Session::Result Session::unsubscribe(const json::object& params) {
  ParamReader read{params};
  if (auto error = read.finish()) return std::unexpected(*error);
  subscription_.reset();
  return json::object{{"topics", json::array{}}};
}

}  // namespace truepose::daemon
