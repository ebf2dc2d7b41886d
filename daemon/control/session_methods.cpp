#include <algorithm>
#include <boost/asio/post.hpp>
#include <utility>

#include "daemon/control/session.hpp"
#include "proto/control/json_text.hpp"
#include "proto/control/schema.hpp"
#include "proto/rpc/methods.hpp"

// What a session answers itself, and whom it asks for the rest.

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

using control::ErrorCode;
using control::Role;
using control::RpcError;

constexpr int kProtocol = 1;
constexpr int kProtocolMinor = 1;  // rises with each addition
constexpr const char* kProduct = "trueposed";

bool is_command(const control::Request& request) {
  const rpc::Method* const known = rpc::method_named(request.method);
  return known && known->role > Role::Viewer;
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

bool Session::opens_session(std::string_view method) {
  return rpc::is_of<rpc::SessionChallenge>(method) || rpc::is_of<rpc::SessionHello>(method);
}

const std::vector<Served<Session>>& Session::answered() {
  static const std::vector<Served<Session>> kAnswered{&Session::challenge,
                                                      &Session::hello,
                                                      &Session::ping,
                                                      &Session::system_info,
                                                      &Session::subscribe,
                                                      &Session::discover,
                                                      &Session::who_has_control,
                                                      &Session::audit_records,
                                                      &Session::unsubscribe,
                                                      &Session::job};
  return kAnswered;
}

const Served<Session>* Session::answered(std::string_view method) {
  const auto found = std::ranges::find(answered(), method, &Served<Session>::name);
  return found == answered().end() ? nullptr : &*found;
}

const std::set<std::string, std::less<>>& Session::own_methods() {
  static const std::set<std::string, std::less<>> kMethods = [] {
    std::set<std::string, std::less<>> all;
    for (const Served<Session>& each : answered()) all.emplace(each.name);
    for (const std::string_view command : Commands::own_methods()) all.emplace(command);
    return all;
  }();
  return kMethods;
}

void Session::greet() {
  rpc::Greeting greeting{.product = kProduct,
                         .version = TRUEPOSE_VERSION,
                         .protocol = {kProtocol, kProtocolMinor},
                         .cell = context_->cell_name,
                         .time = control::rfc3339(context_->parts.wall_clock()),
                         .auth = {"token", "proof"}};
  if (certificate_) greeting.auth.emplace_back("certificate");
  if (peer_.trusted) greeting.auth.emplace_back("none");
  send(control::encode_notification("greeting", record::to_json(greeting)));
}

asio::awaitable<Session::Result> Session::call(control::Request request) {
  if (opens_session(request.method))
    co_return std::unexpected(RpcError{ErrorCode::InvalidRequest, "the session is open already"});
  if (auto refused = forbidden(request.method)) co_return std::unexpected(*refused);
  if (const Served<Session>* const own = answered(request.method)) {
    auto answering = own->carry_out(*this, std::move(request.params), caller_.name);
    Result result = co_await std::move(answering);
    co_return result;
  }
  if (own_methods().contains(request.method)) {
    Result result = co_await context_->commands->carry_out(caller_, peer(), std::move(request));
    co_return result;
  }
  if (!context_->cell_methods.contains(request.method))
    co_return std::unexpected(
        RpcError{ErrorCode::MethodNotFound, "no method \"" + request.method.substr(0, 64) + "\""});
  const auto taken = rpc::take_params<rpc::AsJob>(request.params);
  if (!taken) co_return std::unexpected(taken.error());
  if (taken->job) co_return begin_job(std::move(request));
  Result result = co_await ask_cell(context_, caller_, peer(), std::move(request));
  co_return result;
}

Reply<rpc::Discover> Session::discover(rpc::Discover request) {
  if (!request.of_method) co_return control::openrpc_outline();
  const json::value* const found = control::openrpc_method(*request.of_method);
  if (found) co_return *found;
  co_return std::unexpected(
      RpcError{ErrorCode::NotFound, "the schema has no method \"" + *request.of_method + "\""});
}

Reply<rpc::ControlGet> Session::who_has_control(rpc::ControlGet) {
  co_return context_->commands->who_has_control();
}

Reply<rpc::AuditList> Session::audit_records(rpc::AuditList request) {
  return context_->commands->records(std::move(request));
}

// Jobs.

Session::Result Session::begin_job(control::Request request) {
  std::string method = request.method;
  Jobs::Call call = [context = context_, caller = caller_, from = peer(),
                     request = std::move(request)]() -> asio::awaitable<Result> {
    return ask_cell(context, caller, from, request);
  };
  Jobs::Tell tell = [weak = weak_from_this()](const rpc::Job& job) {
    const auto self = weak.lock();
    if (self && !self->finishing_) self->send(control::encode_notification("job", record::to_json(job)));
  };
  auto id = context_->jobs->begin(std::move(method), caller_.name, std::move(call), std::move(tell));
  if (!id) return std::unexpected(id.error());
  return record::to_json(rpc::JobBegun{*id});
}

Reply<rpc::JobGet> Session::job(rpc::JobGet request) {
  auto known = context_->jobs->find(request.id, caller_.name);
  if (known) co_return *std::move(known);
  co_return std::unexpected(RpcError{
      ErrorCode::NotFound, "no such job of " + caller_.name + "; ended ones are kept for ten minutes"});
}

// Hello.

Reply<rpc::SessionChallenge> Session::challenge(rpc::SessionChallenge) {
  terms_ = {peer_.endpoint, {}, control::new_nonce(context_->parts.random)};
  co_return rpc::SessionChallenge::Result{.nonce = terms_.server_nonce};
}

Admission::Known Session::caller_of(const rpc::SessionHello& hello) const {
  if (hello.token) return context_->admission->by_token(*hello.token);
  if (hello.proof) return context_->admission->by_proof(*hello.proof, terms_);
  if (peer_.trusted) return Caller{peer_.name, Role::Admin};
  return context_->admission->by_certificate(*certificate_);
}

void Session::check_access() {
  if (!authenticated() || context_->admission->still_known(caller_)) return;
  dismiss({ErrorCode::Unauthenticated, "closed: the access of " + caller_.name + " was changed or revoked"});
  connection_->end_reading();
}

std::optional<RpcError> Session::forbidden(const std::string& method) const {
  const rpc::Method* const known = rpc::method_named(method);
  if (!known || caller_.role >= known->role) return std::nullopt;
  return RpcError{ErrorCode::Forbidden, method + " needs the role " +
                                            std::string{control::name(known->role)} + "; " + caller_.name +
                                            " is " + std::string{control::name(caller_.role)}};
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

Reply<rpc::SessionHello> Session::hello(rpc::SessionHello request) {
  if (!request.token && !request.proof && !peer_.trusted && !certificate_)
    co_return rpc::refused("token", "is missing");
  terms_.client_nonce = request.nonce.value_or("");

  // Checked before the delay: clients without the token must not keep out a client with it.
  context_->refresh_access();
  auto attempt = caller_of(request);
  stage_ = attempt ? Stage::Right : Stage::Wrong;
  const auto caller = co_await context_->admission->judge(peer(), std::move(attempt), peer_.trusted);
  if (!caller) co_return std::unexpected(RpcError{ErrorCode::Unauthenticated, caller.error()});
  if (auto error = no_room()) co_return std::unexpected(*error);
  stage_ = Stage::Open;
  caller_ = *caller;
  context_->commands->see_connections();
  heartbeat_ = request.heartbeat_s;
  lines_.set_max_line(control::kMaxLine);
  rpc::SessionHello::Result welcome{.product = kProduct,
                                    .version = TRUEPOSE_VERSION,
                                    .protocol = kProtocol,
                                    .cell = context_->cell_name,
                                    .name = caller_.name,
                                    .role = caller_.role,
                                    .time = control::rfc3339(context_->parts.wall_clock()),
                                    .next_seq = context_->parts.events.next_seq()};
  if (request.proof) welcome.proof = context_->admission->proof(terms_);
  co_return welcome;
}

Reply<rpc::SystemInfo> Session::system_info(rpc::SystemInfo) {
  const std::chrono::duration<double> uptime = context_->parts.clock.now() - context_->started;
  rpc::SystemInfo::Result info{.product = kProduct,
                               .version = TRUEPOSE_VERSION,
                               .protocol = kProtocol,
                               .cell = context_->cell_name,
                               .time = control::rfc3339(context_->parts.wall_clock()),
                               .started = context_->started_text,
                               .uptime_s = uptime.count(),
                               .connections = context_->sessions.size()};
  if (context_->tls) {
    const control::Certificate& ours = context_->tls->certificate();
    info.tls = {.fingerprint = ours.fingerprint, .valid_until = control::rfc3339(ours.until)};
  }
  co_return info;
}

Reply<rpc::EventsSubscribe> Session::subscribe(rpc::EventsSubscribe request) {
  EventBus& events = context_->parts.events;
  const std::uint64_t last = events.next_seq() - 1;
  const std::uint64_t last_seen = request.after.value_or(last);
  if (last_seen > last)
    co_return rpc::refused("after", "expected a whole number 0.." + std::to_string(last) + ", found " +
                                        std::to_string(last_seen));
  std::set<control::Topic> topics;
  for (const auto& [name, topic] : control::kTopics)
    if (!request.topics || std::ranges::count(*request.topics, topic) > 0) topics.insert(topic);

  subscription_.reset();
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
  subscription_ = events.subscribe(topics, request.after ? last_seen : next - 1, wake);
  ++subscriptions_;
  rpc::EventsSubscribe::Result subscribed{
      .topics = {topics.begin(), topics.end()}, .next = next, .oldest = oldest, .complete = gaps->empty()};
  for (const EventGap& gap : *gaps) subscribed.missing.push_back({gap.first, gap.last, gap.reason});
  co_return subscribed;
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

Reply<rpc::SessionPing> Session::ping(rpc::SessionPing) {
  co_return rpc::SessionPing::Result{.time = control::rfc3339(context_->parts.wall_clock()),
                                     .next_seq = context_->parts.events.next_seq()};
}

Reply<rpc::EventsUnsubscribe> Session::unsubscribe(rpc::EventsUnsubscribe) {
  subscription_.reset();
  co_return rpc::EventsUnsubscribe::Result{};
}

}  // namespace truepose::daemon
