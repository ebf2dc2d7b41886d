#include "tools/truepose/rpc_client.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "proto/control/session_proof.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
using control::ErrorCode;
using namespace std::chrono_literals;

constexpr std::chrono::seconds kHelloPatience = 5s;

/// A text member; empty where there is none.
std::string text_of(const json::value& object, std::string_view key) {
  const json::object* const members = object.if_object();
  const json::value* const member = members ? members->if_contains({key.data(), key.size()}) : nullptr;
  return member && member->is_string() ? std::string{member->get_string()} : "";
}

std::expected<std::string, ClientError> read_token(const std::filesystem::path& file) {
  const auto bad = [](const std::string& why) { return std::unexpected(ClientError{kBadInput, why}); };
  if (file.empty()) return bad("no token: give --token-file FILE or set TRUEPOSE_TOKEN_FILE");
  std::ifstream stream{file};
  std::string token;
  if (!stream.is_open()) return bad("token file " + file.string() + ": " + std::strerror(errno));
  if (!(stream >> token)) return bad("token file " + file.string() + ": is empty");
  return token;
}

/// What a refusal means for the caller of a command.
int exit_code(ErrorCode code) {
  switch (code) {
    case ErrorCode::Unauthenticated:
    case ErrorCode::InvalidParams:
    case ErrorCode::MethodNotFound:
      return kBadInput;
    case ErrorCode::Device:
      return kUnreachable;
    default:
      return kFailed;
  }
}

ClientError refusal(const std::string& method, const control::RpcError& error) {
  std::string text = method + ": " + error.message + " (" + std::to_string(static_cast<int>(error.code));
  if (!error.state.empty()) {
    text += "; the state is " + error.state + ", which allows";
    for (const auto& allowed : error.allowed) text += " " + allowed;
    if (error.allowed.empty()) text += " nothing";
  }
  return {exit_code(error.code), text + ")"};
}

}  // namespace

RpcClient::RpcClient(RpcClient&& other) noexcept
    : socket_{std::exchange(other.socket_, -1)},
      daemon_{std::move(other.daemon_)},
      lines_{std::move(other.lines_)},
      events_{std::move(other.events_)},
      last_id_{other.last_id_} {}

RpcClient::~RpcClient() {
  if (socket_ >= 0) ::close(socket_);
}

std::expected<RpcClient, ClientError> RpcClient::connect(const std::string& daemon,
                                                         const std::filesystem::path& token_file) {
  const auto connection = connect_to_daemon(daemon);
  if (!connection) return std::unexpected(connection.error());
  RpcClient client{connection->socket, connection->daemon};
  const auto opened = connection->endpoint.empty() ? client.open_locally()
                                                   : client.open_by_proof(connection->endpoint, token_file);
  if (!opened) return std::unexpected(opened.error());
  return client;
}

std::expected<void, ClientError> RpcClient::open_locally() {
  const auto hello = call("session.hello", {{"protocol", 1}}, kHelloPatience);
  if (!hello) return std::unexpected(hello.error());
  return {};
}

// Whoever sits at the daemon's port learns nothing from it, and is found out unless he knows the token too.
std::expected<void, ClientError> RpcClient::open_by_proof(const std::string& endpoint,
                                                          const std::filesystem::path& token_file) {
  const auto token = read_token(token_file);
  if (!token) return std::unexpected(token.error());
  const auto challenge = call("session.challenge", {}, kHelloPatience);
  if (!challenge) return std::unexpected(challenge.error());
  const ClientError stranger{
      kUnreachable,
      "whoever answers at " + daemon_ + " does not know the token: no trueposed, or one of another cell"};
  const std::string server_nonce = text_of(*challenge, "nonce");
  if (!control::is_nonce(server_nonce)) return std::unexpected(stranger);
  const control::SessionTerms terms{endpoint, control::new_nonce(), server_nonce};
  const auto hello = call("session.hello",
                          {{"protocol", 1},
                           {"nonce", terms.client_nonce},
                           {"proof", session_proof(*token, control::Prover::Client, terms)}},
                          kHelloPatience);
  if (!hello) return std::unexpected(hello.error());
  if (text_of(*hello, "proof") != session_proof(*token, control::Prover::Server, terms))
    return std::unexpected(stranger);
  return {};
}

std::expected<json::value, ClientError> RpcClient::call(const std::string& method, const json::object& params,
                                                        std::chrono::seconds patience) {
  const control::Id id{++last_id_};
  if (auto sent = send(control::encode_request(id, method, params)); !sent)
    return std::unexpected(sent.error());
  const auto deadline = Clock::now() + patience;
  while (true) {
    auto message = receive(deadline);
    if (!message) return std::unexpected(message.error());
    if (auto* event = std::get_if<control::Event>(&*message)) {
      events_.push_back(std::move(*event));
      continue;
    }
    auto& reply = std::get<control::Reply>(*message);
    // An error without an id is the server's farewell.
    const bool farewell = std::holds_alternative<std::monostate>(reply.id) && !reply.result;
    if (reply.id != id && !farewell) continue;
    if (!reply.result) return std::unexpected(refusal(method, reply.result.error()));
    return std::move(*reply.result);
  }
}

std::expected<control::Event, ClientError> RpcClient::next_event() {
  while (events_.empty()) {
    auto message = receive(Clock::time_point::max());
    if (!message) return std::unexpected(message.error());
    if (auto* event = std::get_if<control::Event>(&*message)) events_.push_back(std::move(*event));
  }
  control::Event event = std::move(events_.front());
  events_.pop_front();
  return event;
}

ClientError RpcClient::lost(const std::string& why) const {
  return {kUnreachable, "the connection to the daemon at " + daemon_ + " is lost: " + why};
}

std::expected<void, ClientError> RpcClient::send(const std::string& line) {
  const auto deadline = Clock::now() + kHelloPatience;
  std::size_t sent = 0;
  while (sent < line.size()) {
    const ssize_t size = ::send(socket_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
    if (size >= 0) {
      sent += static_cast<std::size_t>(size);
    } else if (errno != EAGAIN && errno != EINTR) {
      return std::unexpected(lost(std::strerror(errno)));
    } else if (!wait_for(socket_, POLLOUT, deadline)) {
      return std::unexpected(lost("it takes no more requests"));
    }
  }
  return {};
}

std::expected<RpcClient::Message, ClientError> RpcClient::receive(Clock::time_point deadline) {
  while (true) {
    if (const auto line = lines_.next()) {
      auto message = control::decode_server_line(*line);
      if (!message) return std::unexpected(lost(message.error() + "; is it trueposed?"));
      return std::move(*message);
    }
    if (lines_.overflowed())
      return std::unexpected(lost("it sends lines longer than allowed; is it trueposed?"));
    if (!wait_for(socket_, POLLIN, deadline)) return std::unexpected(lost("no answer in time"));
    std::array<char, 16 * 1024> bytes;
    const ssize_t size = ::recv(socket_, bytes.data(), bytes.size(), 0);
    if (size == 0) return std::unexpected(lost("the daemon closed it"));
    if (size > 0) lines_.push({bytes.data(), static_cast<std::size_t>(size)});
    if (size < 0 && errno != EAGAIN && errno != EINTR) return std::unexpected(lost(std::strerror(errno)));
  }
}

}  // namespace truepose::tools
