#include "tools/truepose/online/rpc_client.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "config/text_file.hpp"
#include "core/formatted.hpp"
#include "proto/control/access.hpp"
#include "proto/control/session_proof.hpp"
#include "tools/truepose/online/online_commands.hpp"

namespace truepose::tools {
namespace {

using namespace std::chrono_literals;
namespace json = boost::json;
using control::ErrorCode;

constexpr std::chrono::seconds kHelloPatience = 5s;
// A command may think for long between two calls; while it listens it says now and then that it is there.
constexpr std::chrono::seconds kHeartbeat = 600s, kPing = 120s;

// ---- The session ----

std::expected<std::string, CommandError> read_token(const std::filesystem::path& file) {
  const auto bad = [](const std::string& why) { return std::unexpected(CommandError{kBadInput, why}); };
  if (file.empty()) return bad("no token: give --token-file FILE or set TRUEPOSE_TOKEN_FILE");
  try {
    auto token = control::token_in(config::read_text_file(file));
    if (!token) return bad("token file " + file.string() + ": " + token.error());
    return *std::move(token);
  } catch (const config::ConfigError& error) {
    return bad("token file " + std::string{error.what()});
  }
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

/// What an operator can type instead of what the state does not allow.
std::string possible_commands(const std::vector<std::string>& allowed) {
  std::string names;
  for (const std::string& method : allowed)
    if (const std::string command = command_calling(method); !command.empty())
      names += (names.empty() ? "" : ", ") + ("truepose " + command);
  return names.empty() ? "" : ". Possible: " + names;
}

/// The daemon's sentence, with commands in the place of methods.
CommandError refusal(const std::string& method, const control::RpcError& error) {
  const std::string command = command_calling(method);
  const std::string why = error.message.substr(0, error.message.find("; allowed: "));
  std::string text = (command.empty() ? method : command) + ": " + why;
  if (!error.state.empty() && !why.contains("in state " + error.state))
    text += " (state " + error.state + ")";
  return {exit_code(error.code), text + possible_commands(error.allowed), "", static_cast<int>(error.code)};
}

}  // namespace

std::expected<RpcClient, CommandError> RpcClient::connect(const DaemonAddress& address) {
  auto connection = connect_to_daemon(address);
  if (!connection) return std::unexpected(connection.error());
  const std::string endpoint = connection->endpoint;
  RpcClient client{std::move(connection->channel), connection->daemon};
  const bool known_by_transport =
      endpoint.empty() || (!address.tls.certificate.empty() && address.token_file.empty());
  const auto opened = known_by_transport ? client.hello({}) : client.open_by_token(endpoint, address);
  if (!opened) return std::unexpected(opened.error());
  return client;
}

/// @param request  with what shows who asks
std::expected<json::value, CommandError> RpcClient::hello(rpc::SessionHello request) {
  request.protocol = 1;
  request.heartbeat_s = kHeartbeat;
  return call(rpc::SessionHello::method().name, record::to_json(request), kHelloPatience);
}

std::expected<json::value, CommandError> RpcClient::open_by_token(const std::string& endpoint,
                                                                  const DaemonAddress& address) {
  const auto token = read_token(address.token_file);
  if (!token) return std::unexpected(token.error());
  const bool sees_whom = !address.tls.ca.empty();  // and may be behind another address than the daemon's own
  if (!sees_whom && !token->starts_with(control::kAccessTokenStart)) return open_by_proof(endpoint, *token);
  return hello({.token = *token});
}

// Another server at the daemon's port learns nothing from it, and is detected unless it knows the token too.
std::expected<json::value, CommandError> RpcClient::open_by_proof(const std::string& endpoint,
                                                                  const std::string& token) {
  using Challenge = rpc::SessionChallenge;
  auto challenge = call(Challenge::method().name, {}, kHelloPatience);
  if (!challenge) return challenge;
  const CommandError unexpected_server{
      kUnreachable,
      "the server at " + daemon_ + " does not know the token: no trueposed, or one of another cell"};
  const auto given = record::from_json<Challenge::Result>(*challenge);
  if (!given || !control::is_nonce(given->nonce)) return std::unexpected(unexpected_server);
  const control::SessionTerms terms{endpoint, control::new_nonce(kernel_random), given->nonce};
  auto greeting =
      hello({.nonce = terms.client_nonce, .proof = session_proof(token, control::Prover::Client, terms)});
  if (!greeting) return greeting;
  const auto known = record::from_json<rpc::SessionHello::Result>(*greeting);
  if (!known || known->proof != session_proof(token, control::Prover::Server, terms))
    return std::unexpected(unexpected_server);
  return greeting;
}

std::expected<json::value, CommandError> RpcClient::call(std::string_view method, const json::object& params,
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
    if (!reply.result) return std::unexpected(refusal(std::string{method}, reply.result.error()));
    return std::move(*reply.result);
  }
}

std::expected<control::Event, CommandError> RpcClient::next_event(
    std::optional<std::chrono::duration<double>> patience) {
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(patience.value_or(kPing));
  for (bool asked = false; events_.empty();) {
    const auto next_ping = Clock::now() + kPing;
    const auto deadline = patience ? std::min(end, next_ping) : next_ping;
    auto message = receive(deadline);
    if (!message && patience && Clock::now() >= end)
      return std::unexpected(CommandError{kFailed, formatted("events: none within %g s", patience->count())});
    if (!message && (asked || Clock::now() < deadline)) return std::unexpected(message.error());
    if (!message) {
      const auto sent = send(control::encode_request(++last_id_, rpc::SessionPing::method().name, {}));
      if (!sent) return std::unexpected(sent.error());
    }
    asked = !message;
    if (!message) continue;
    if (auto* event = std::get_if<control::Event>(&*message)) events_.push_back(std::move(*event));
  }
  control::Event event = std::move(events_.front());
  events_.pop_front();
  return event;
}

CommandError RpcClient::lost(const std::string& why) const {
  return {kUnreachable, "the connection to the daemon at " + daemon_ + " is lost: " + why};
}

std::expected<void, CommandError> RpcClient::send(const std::string& line) {
  const auto sent = channel_->write(line, Clock::now() + kHelloPatience);
  if (!sent) return std::unexpected(lost(sent.error()));
  return {};
}

std::expected<RpcClient::Message, CommandError> RpcClient::receive(Clock::time_point deadline) {
  while (true) {
    if (const auto line = lines_.next()) {
      auto message = control::decode_server_line(*line);
      if (!message) return std::unexpected(lost(message.error() + "; is it trueposed?"));
      if (std::holds_alternative<control::Notification>(*message)) continue;  // nothing that a command shows
      return std::move(*message);
    }
    if (lines_.overflowed())
      return std::unexpected(lost("it sends lines longer than allowed; is it trueposed?"));
    std::array<char, 16 * 1024> bytes;
    const auto size = channel_->read_some(bytes, deadline);
    if (!size) return std::unexpected(lost(size.error()));
    lines_.push({bytes.data(), *size});
  }
}

}  // namespace truepose::tools
