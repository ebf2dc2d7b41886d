#include "tools/truepose/rpc_client.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <utility>

namespace truepose::tools {
namespace {

namespace json = boost::json;
using control::ErrorCode;
using namespace std::chrono_literals;

constexpr std::chrono::seconds kConnectPatience = 5s;

/// Waits for a socket. @return false when the time is over
bool wait_for(int socket, short events, std::chrono::steady_clock::time_point deadline) {
  while (true) {
    int wait_ms = -1;
    if (deadline != std::chrono::steady_clock::time_point::max()) {
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
      wait_ms = static_cast<int>(std::max<std::int64_t>(left.count(), 0));
    }
    pollfd watched{socket, events, 0};
    const int ready = ::poll(&watched, 1, wait_ms);
    if (ready > 0) return true;
    if (ready == 0 || errno != EINTR) return false;
  }
}

/// Connects to one address. @return 0, or the errno that says why not
int try_connect(int socket, const addrinfo& address) {
  if (::connect(socket, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (!wait_for(socket, POLLOUT, std::chrono::steady_clock::now() + kConnectPatience)) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

std::expected<int, ClientError> open_connection(const std::string& daemon) {
  const auto colon = daemon.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == daemon.size())
    return std::unexpected(ClientError{kBadInput, "--daemon: expected HOST:PORT, found \"" + daemon + "\""});
  std::string host = daemon.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);

  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), daemon.c_str() + colon + 1, &hints, &found))
    return std::unexpected(ClientError{kBadInput, "--daemon " + daemon + ": " + ::gai_strerror(error)});
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses{found, &::freeaddrinfo};

  int error = 0;
  for (const addrinfo* address = found; address; address = address->ai_next) {
    const int socket = ::socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    error = socket < 0 ? errno : try_connect(socket, *address);
    if (error == 0) return socket;
    if (socket >= 0) ::close(socket);
  }
  return std::unexpected(ClientError{kUnreachable, "the daemon at " + daemon + " cannot be reached (" +
                                                       std::strerror(error) + "); is trueposed running?"});
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
  const auto token = read_token(token_file);
  if (!token) return std::unexpected(token.error());
  const auto socket = open_connection(daemon);
  if (!socket) return std::unexpected(socket.error());
  RpcClient client{*socket, daemon};
  const auto hello = client.call("session.hello", {{"protocol", 1}, {"token", *token}}, kConnectPatience);
  if (!hello) return std::unexpected(hello.error());
  return client;
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
  const auto deadline = Clock::now() + kConnectPatience;
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
