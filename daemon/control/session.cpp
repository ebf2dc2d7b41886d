#include "daemon/control/session.hpp"

#include <algorithm>
#include <utility>

#include "daemon/control/control_server.hpp"
#include "drivers/deadline.hpp"
#include "drivers/net/spawn.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

using control::ErrorCode;
using control::RpcError;

constexpr std::size_t kEventsPerBatch = 64;

}  // namespace

void SessionContext::refresh_access() {
  if (!admission->refresh()) return;
  const std::vector<Session*> all = sessions;
  for (Session* session : all) session->check_access();
}

bool SessionContext::is_connected(const Caller& who) const {
  return std::ranges::any_of(sessions, [&](const Session* session) {
    return session->stage() == Session::Stage::Open && session->caller().name == who.name;
  });
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
      wake_{connection_->executor()},
      drained_{connection_->executor()},
      lines_{control::kMaxLineBeforeHello},
      connected_{context_->parts.clock.now()},
      last_request_{connected_} {
  context_->sessions.push_back(this);
}

Session::~Session() { std::erase(context_->sessions, this); }

void Session::start() {
  const auto done = [self = shared_from_this()](std::exception_ptr) { self->close(); };
  net::spawn(connection_->executor(), read_requests(), done, cancel_.slot());
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
    self->drained_.notify();
  };
  net::spawn(connection_->executor(), write_lines(), done);
}

void Session::close() {
  connection_->close();
  subscription_.reset();
  finishing_ = true;
  context_->commands->see_connections();
  wake_.notify();
  drained_.notify();
}

void Session::send(std::string line) {
  outgoing_ += line;
  wake_.notify();
}

void Session::dismiss(RpcError error) {
  send(control::encode_error({}, error));
  finishing_ = true;
}

// Reading.

asio::awaitable<bool> Session::open() {
  const drivers::TimePoint until = connected_ + context_->limits.hello;
  auto opened = co_await drivers::before(context_->parts.clock, until, connection_->open());
  if (!opened) co_return false;
  if (!*opened) context_->warn_of_tls(peer(), opened->error());
  if (*opened) certificate_ = **std::move(opened);
  co_return opened->has_value();
}

asio::awaitable<void> Session::read_requests() {
  if (!co_await open()) co_return;
  if (!finishing_) greet();
  spawn_writer();
  while (!finishing_) {
    const std::optional<drivers::TimePoint> until = deadline();
    const std::size_t size = co_await read_some(until);
    if (size == 0) {
      if (until && context_->parts.clock.now() >= *until)
        dismiss({ErrorCode::InvalidRequest, !authenticated() ? "closed: no session.hello came in time"
                                            : line_started_.has_value()
                                                ? "closed: the line did not end in time"
                                                : "closed: nothing was asked for too long; ask for "
                                                  "session.ping now and then, or name a longer heartbeat_s "
                                                  "at session.hello"});
      finishing_ = true;
      wake_.notify();
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
  while (!written_) co_await drained_.wait();
}

std::optional<drivers::TimePoint> Session::deadline() const {
  const ControlLimits& limits = context_->limits;
  if (!authenticated()) return connected_ + limits.hello;
  if (line_started_) return *line_started_ + limits.line;
  if (heartbeat_) return last_request_ + *heartbeat_;
  if (subscription_) return std::nullopt;
  return last_request_ + limits.idle;
}

asio::awaitable<std::size_t> Session::read_some(std::optional<drivers::TimePoint> deadline) {
  auto reading = connection_->read_some(asio::buffer(input_));
  if (!deadline) {
    const std::size_t size = co_await std::move(reading);
    co_return size;
  }
  const auto size = co_await drivers::before(context_->parts.clock, *deadline, std::move(reading));
  co_return size.value_or(0);
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

  ++context_->requests;
  const control::Id id = request->id;
  // Now and not only from time to time: whose access was revoked is answered nothing more.
  if (authenticated()) context_->refresh_access();
  if (finishing_) co_return;
  Result result;
  if (authenticated()) {
    result = co_await call(std::move(*request));
  } else if (opens_session(request->method)) {
    auto answering = answered(request->method)->carry_out(*this, std::move(request->params), caller_.name);
    result = co_await std::move(answering);
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
  if (!authenticated() && !(result && rpc::is_of<rpc::SessionChallenge>(request->method))) finishing_ = true;
  // A client that asks without reading the answers waits, rather than filling our memory.
  while (!outgoing_.empty() && !finishing_) co_await drained_.wait();
}

// Not left to the writer, which may be stuck in a write to this very client.
void Session::see_events() {
  wake_.notify();
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
  EventBus::Taken taken = subscription_->take(kEventsPerBatch);
  for (std::size_t i = 0; i < taken.lines.size(); ++i) {
    const bool after_gap = i == 0 && !taken.dropped.empty();
    batch += after_gap ? control::event_after_drops(*taken.lines[i], taken.dropped) : *taken.lines[i];
  }
  for (const auto& [topic, count] : taken.dropped) context_->dropped_events[topic] += count;
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
    // By then another user may have it, or none.
    if (!subscription_ || subscription != subscriptions_) break;
    if (!page) {
      context_->parts.warn("control: " + page.error().detail);
      dismiss({ErrorCode::Internal, "closed: what was missed cannot be read: " + page.error().detail});
      break;
    }
    subscription_->resume_from(page->next);
    for (const KeptEvent& event : page->events)
      batch += control::encode_event_text(event.seq, event.time, event.topic, event.data);
  }
  co_return batch + std::exchange(outgoing_, {});
}

asio::awaitable<void> Session::write_lines() {
  drivers::Clock& clock = context_->parts.clock;
  const ControlLimits& limits = context_->limits;
  while (true) {
    const std::string batch = co_await next_batch();
    if (batch.empty()) {
      if (finishing_) {
        co_await drivers::before(clock, clock.now() + limits.farewell, connection_->end_writing());
        co_return;  // the reader closes, once the client has had time to read
      }
      co_await wake_.wait();
      continue;
    }
    auto writing = connection_->write(asio::buffer(batch));
    const auto written =
        co_await drivers::before(clock, clock.now() + limits.write_stall, std::move(writing));
    if (!written.value_or(false)) break;
    drained_.notify();
  }
  close();
}

}  // namespace truepose::daemon
