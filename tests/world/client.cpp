#include "tests/world/client.hpp"

#include <fmt/format.h>

#include <array>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <limits>
#include <utility>

#include "drivers/net/spawn.hpp"
#include "proto/control/access.hpp"
#include "proto/control/session_proof.hpp"
#include "tests/world/answers.hpp"

namespace truepose::world {

namespace asio = boost::asio;
namespace json = boost::json;

namespace {

constexpr std::uint16_t kControlPort = 7210;

}  // namespace

/// A connection, and who waits for answers on it.
struct Client::Session {
  struct Waiting {
    daemon::Signal answered;
    std::optional<json::value> answer;
  };
  std::unique_ptr<net::Stream> stream;
  std::map<std::int64_t, std::shared_ptr<Waiting>> open;
  std::int64_t last_id = 0;
  std::string line;
  std::uint64_t all_from = std::numeric_limits<std::uint64_t>::max();  // events, from then on
  bool is_open = false, over = false;
  std::function<void()> on_end;  // of one that was open

  void end() {
    if (is_open && !over) on_end();
    over = true;
    stream->close();
    for (const auto& [id, request] : open) {
      request->answer.emplace(nullptr);
      request->answered.notify();
    }
    open.clear();
  }
};

Client::Client(World& world, std::string name, std::string token, json::array topics)
    : world_{world}, name_{std::move(name)}, token_{std::move(token)}, topics_(std::move(topics)) {}

Client::~Client() {
  if (!session_) return;
  session_->on_end = [] {};  // whom it would inform may be gone
  session_->end();
}

void Client::disconnect() {
  if (session_) session_->end();
}

asio::awaitable<void> Client::disconnect_within_a_line() {
  const auto session = session_;
  if (!session || session->over) co_return;
  co_await session->stream->write(R"({"jsonrpc": "2.0", "id": 1, "meth)");
  session->end();
}

bool Client::is_connected() const { return session_ && !session_->over; }

asio::awaitable<bool> Client::connect() {
  if (session_) session_->end();
  reads_at_ = {};
  session_ = std::make_shared<Session>();
  const auto session = session_;
  session->stream = world_.network.streams()(world_.outside.get_executor());
  const auto failed = co_await session->stream->connect("127.0.0.1", kControlPort);
  if (failed) {
    session->end();
    co_return false;
  }
  net::spawn(world_.outside.get_executor(), read(*this, session), net::rethrow);
  json::object hello = co_await credentials();
  const json::value opened = co_await ask("session.hello", std::move(hello));
  if (!is_result(opened)) co_return false;
  const json::object& welcome = result_of(opened);
  user_ = welcome.at("name").as_string();
  role_ = welcome.at("role").as_string();
  session->is_open = true;
  session->on_end = [this] { on_session(false); };
  on_session(true);
  const bool subscribed = co_await subscribe();
  co_return subscribed;
}

/// A token of the access list is shown itself, that of the token file is proven.
asio::awaitable<json::object> Client::credentials() {
  json::object hello{{"protocol", 1}};
  if (token_.starts_with(control::kAccessTokenStart)) {
    hello["token"] = token_;
    co_return hello;
  }
  const json::value challenge = co_await ask("session.challenge");
  if (!is_result(challenge)) co_return hello;
  const control::SessionTerms terms{.endpoint = "127.0.0.1 " + std::to_string(kControlPort),
                                    .client_nonce = fmt::format("{:032x}", ++proofs_),
                                    .server_nonce = text_at(result_of(challenge), "nonce")};
  hello["nonce"] = terms.client_nonce;
  hello["proof"] = control::session_proof(token_, control::Prover::Client, terms);
  co_return hello;
}

asio::awaitable<bool> Client::subscribe() {
  const auto session = session_;
  json::object from{{"after", seq_}};
  if (!topics_.empty()) from["topics"] = topics_;
  const json::value subscribed = co_await ask("events.subscribe", std::move(from));
  if (!is_result(subscribed)) co_return false;
  session->all_from = result_of(subscribed).at("next").to_number<std::uint64_t>();
  on_subscribed(result_of(subscribed));
  co_return true;
}

asio::awaitable<bool> Client::subscribe_again() {
  const json::value ended = co_await ask("events.unsubscribe");
  if (ended.is_null()) co_return false;
  session_->all_from = std::numeric_limits<std::uint64_t>::max();
  const bool subscribed = co_await subscribe();
  co_return subscribed;
}

bool Client::is_late(const json::object& event) const {
  return event.at("seq").to_number<std::uint64_t>() < session_->all_from;
}

asio::awaitable<json::value> Client::ask(std::string method, json::object params) {
  const auto session = session_;
  if (!session || session->over) co_return nullptr;
  Request request{.method = std::move(method), .params = std::move(params), .asked = world_.clock.now()};
  on_request(request);
  const auto waiting = std::make_shared<Session::Waiting>();
  const std::int64_t id = ++session->last_id;
  session->open[id] = waiting;
  const json::object line{
      {"jsonrpc", "2.0"}, {"id", id}, {"method", request.method}, {"params", request.params}};
  const std::string text = json::serialize(line) + "\n";
  const auto failed = co_await session->stream->write(text);
  if (failed) session->end();
  while (!waiting->answer) co_await waiting->answered.wait();
  request.answer = *waiting->answer;
  request.answered = world_.clock.now();
  on_answer(request);
  co_return request.answer;
}

asio::awaitable<void> Client::read(Client& client, std::shared_ptr<Session> session) {
  std::array<char, 4096> buffer{};
  while (!session->over) {
    while (!client.reads()) co_await client.world_.clock.sleep_until(client.reads_at_);
    if (session->over) co_return;
    const auto [error, size] = co_await session->stream->read(buffer);
    if (session->over) co_return;
    if (error || size == 0) break;
    session->line.append(buffer.data(), size);
    for (std::size_t end = 0; (end = session->line.find('\n')) != std::string::npos;) {
      const std::string line = session->line.substr(0, end);
      session->line.erase(0, end + 1);
      client.take(*session, line);
      if (session->over) co_return;
    }
  }
  session->end();
}

void Client::take(Session& session, const std::string& line) {
  const json::object message = json::parse(line).as_object();
  if (const json::value* const id = message.if_contains("id"); id != nullptr && id->is_int64()) {
    const auto asked = session.open.extract(id->as_int64());
    if (asked.empty()) return complaints.push_back(name_ + ": an answer to no request: " + line);
    asked.mapped()->answer.emplace(message);
    return asked.mapped()->answered.notify();
  }
  if (text_at(message, "method") != "event") return;  // a notice, as of why a session ends
  const json::object& event = message.at("params").as_object();
  const std::uint64_t seq = event.at("seq").to_number<std::uint64_t>();
  // Of missed ones not all are kept, and others are of topics that it does not ask for.
  const bool all_come = topics_.empty() && seq > session.all_from;
  const bool follows = all_come ? seq == seq_ + 1 : seq > seq_;
  if (!follows)
    complaints.push_back(name_ + ": event " + std::to_string(seq) + " comes after " + std::to_string(seq_));
  seq_ = seq;
  on_event(event);
}

}  // namespace truepose::world
