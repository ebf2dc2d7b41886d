#include "tools/truepose/online/rpc_client.hpp"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <utility>

#include "config/number_text.hpp"
#include "proto/control/session_proof.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
namespace json = boost::json;
using control::ErrorCode;

constexpr std::chrono::seconds kHelloPatience = 5s;

// ---- The connection ----

/// A connection to a daemon, not yet a session.
struct DaemonConnection {
  int socket = -1;       ///< the caller's to close
  std::string daemon;    ///< for messages
  std::string endpoint;  ///< "127.0.0.1 7210" over TCP; empty over a control socket
};

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

constexpr std::chrono::seconds kConnectPatience = 5s;
constexpr const char* kDefaultTcp = "127.0.0.1:7210";

CommandError unreachable(const std::string& daemon, const std::string& why) {
  return {kUnreachable,
          "the daemon at " + daemon + " cannot be reached (" + why + "); is trueposed running?"};
}

/// As the daemon writes its own end: the address in digits, then the port.
std::string endpoint_of(const addrinfo& address) {
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  ::getnameinfo(address.ai_addr, address.ai_addrlen, host.data(), host.size(), port.data(), port.size(),
                NI_NUMERICHOST | NI_NUMERICSERV);
  return std::string{host.data()} + " " + port.data();
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

std::expected<DaemonConnection, CommandError> connect_over_tcp(const std::string& daemon) {
  const auto endpoint = config::parse_endpoint(daemon);
  if (!endpoint)
    return std::unexpected(CommandError{
        kBadInput, "--daemon: " + endpoint.error() + ", nor is it the path of a control socket"});

  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error =
          ::getaddrinfo(endpoint->host.c_str(), std::to_string(endpoint->port).c_str(), &hints, &found))
    return std::unexpected(CommandError{kBadInput, "--daemon " + daemon + ": " + ::gai_strerror(error)});
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> addresses{found, &::freeaddrinfo};

  int error = 0;
  for (const addrinfo* address = found; address; address = address->ai_next) {
    const int socket = ::socket(address->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    error = socket < 0 ? errno : try_connect(socket, *address);
    if (error == 0) return DaemonConnection{socket, daemon, endpoint_of(*address)};
    if (socket >= 0) ::close(socket);
  }
  return std::unexpected(unreachable(daemon, std::strerror(error)));
}

/// Whether the process behind a control socket is the one that its folder belongs to. A folder that others
/// may write would let anybody put a socket there.
std::optional<std::string> stranger_behind(int socket, const fs::path& path) {
  ucred server{};
  socklen_t size = sizeof server;
  struct stat folder {};
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path{"."};
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &server, &size) != 0 ||
      ::stat(parent.c_str(), &folder) != 0)
    return std::strerror(errno);
  if ((folder.st_mode & (S_IWGRP | S_IWOTH)) != 0) return "others may write to its folder";
  if (server.uid == 0 || server.uid == ::geteuid() || server.uid == folder.st_uid) return std::nullopt;
  return "it is served by uid " + std::to_string(server.uid) + ", and its folder belongs to uid " +
         std::to_string(folder.st_uid);
}

std::expected<DaemonConnection, CommandError> connect_locally(const fs::path& path) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  if (path.native().size() >= sizeof name.sun_path)
    return std::unexpected(
        CommandError{kBadInput, "--daemon " + path.string() + ": is too long for a socket"});
  path.native().copy(name.sun_path, sizeof name.sun_path - 1);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const auto failed = [&](const std::string& why) {
    if (socket >= 0) ::close(socket);
    return std::unexpected(unreachable(path, why));
  };
  if (socket < 0 || ::connect(socket, reinterpret_cast<const sockaddr*>(&name), sizeof name) != 0)
    return failed(std::strerror(errno));
  if (const auto stranger = stranger_behind(socket, path)) return failed(*stranger);
  return DaemonConnection{socket, path, {}};
}

/// The daemon of this machine, where there is one that lets us in.
std::expected<std::optional<DaemonConnection>, CommandError> connect_to_only_one() {
  const char* const user_folder = std::getenv("XDG_RUNTIME_DIR");
  std::optional<DaemonConnection> only;
  std::string names;
  for (const fs::path& path : control_sockets(user_folder ? user_folder : "", "/run/truepose")) {
    const auto connected = connect_locally(path);
    if (!connected) continue;
    names += " " + path.string();
    if (only) ::close(connected->socket);
    if (!only) only = *connected;
  }
  if (!only || names.find(' ', 1) == std::string::npos) return only;
  ::close(only->socket);
  return std::unexpected(CommandError{kBadInput, "several cells run here; choose one by --daemon:" + names});
}

std::expected<DaemonConnection, CommandError> connect_to_daemon(const std::string& daemon) {
  if (daemon.find('/') != std::string::npos) return connect_locally(daemon);
  if (!daemon.empty()) return connect_over_tcp(daemon);
  auto only = connect_to_only_one();
  if (!only) return std::unexpected(only.error());
  if (*only) return **only;
  return connect_over_tcp(kDefaultTcp);
}

// ---- The session ----

std::expected<std::string, CommandError> read_token(const std::filesystem::path& file) {
  const auto bad = [](const std::string& why) { return std::unexpected(CommandError{kBadInput, why}); };
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

CommandError refusal(const std::string& method, const control::RpcError& error) {
  std::string text = method + ": " + error.message + " (" + std::to_string(static_cast<int>(error.code));
  if (!error.state.empty()) {
    text += "; the state is " + error.state + ", which allows";
    for (const auto& allowed : error.allowed) text += " " + allowed;
    if (error.allowed.empty()) text += " nothing";
  }
  return {exit_code(error.code), text + ")"};
}

}  // namespace

std::vector<fs::path> control_sockets(const fs::path& user_folder, const fs::path& system_folder) {
  std::vector<fs::path> found;
  const auto look = [&](const fs::path& folder, const std::string& prefix) {
    std::error_code none;
    std::vector<fs::path> here;
    for (fs::directory_iterator cell{folder, none}, end; !none && cell != end; cell.increment(none)) {
      const fs::path socket = cell->path() / "control.sock";
      std::error_code unseen;
      if (cell->path().filename().string().starts_with(prefix) && fs::is_socket(socket, unseen))
        here.push_back(socket);
    }
    std::ranges::sort(here);
    found.insert(found.end(), here.begin(), here.end());
  };
  if (!user_folder.empty()) look(user_folder, "truepose-");
  look(system_folder, "");
  return found;
}

RpcClient::RpcClient(RpcClient&& other) noexcept
    : socket_{std::exchange(other.socket_, -1)},
      daemon_{std::move(other.daemon_)},
      lines_{std::move(other.lines_)},
      events_{std::move(other.events_)},
      last_id_{other.last_id_} {}

RpcClient::~RpcClient() {
  if (socket_ >= 0) ::close(socket_);
}

std::expected<RpcClient, CommandError> RpcClient::connect(const std::string& daemon,
                                                          const std::filesystem::path& token_file) {
  const auto connection = connect_to_daemon(daemon);
  if (!connection) return std::unexpected(connection.error());
  RpcClient client{connection->socket, connection->daemon};
  const auto opened = connection->endpoint.empty() ? client.open_locally()
                                                   : client.open_by_proof(connection->endpoint, token_file);
  if (!opened) return std::unexpected(opened.error());
  return client;
}

std::expected<void, CommandError> RpcClient::open_locally() {
  const auto hello = call("session.hello", {{"protocol", 1}}, kHelloPatience);
  if (!hello) return std::unexpected(hello.error());
  return {};
}

// Whoever sits at the daemon's port learns nothing from it, and is found out unless he knows the token too.
std::expected<void, CommandError> RpcClient::open_by_proof(const std::string& endpoint,
                                                           const std::filesystem::path& token_file) {
  const auto token = read_token(token_file);
  if (!token) return std::unexpected(token.error());
  const auto challenge = call("session.challenge", {}, kHelloPatience);
  if (!challenge) return std::unexpected(challenge.error());
  const CommandError stranger{
      kUnreachable,
      "whoever answers at " + daemon_ + " does not know the token: no trueposed, or one of another cell"};
  const std::string server_nonce = string_at(*challenge, "/nonce");
  if (!control::is_nonce(server_nonce)) return std::unexpected(stranger);
  const control::SessionTerms terms{endpoint, control::new_nonce(), server_nonce};
  const auto hello = call("session.hello",
                          {{"protocol", 1},
                           {"nonce", terms.client_nonce},
                           {"proof", session_proof(*token, control::Prover::Client, terms)}},
                          kHelloPatience);
  if (!hello) return std::unexpected(hello.error());
  if (string_at(*hello, "/proof") != session_proof(*token, control::Prover::Server, terms))
    return std::unexpected(stranger);
  return {};
}

std::expected<json::value, CommandError> RpcClient::call(const std::string& method,
                                                         const json::object& params,
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

std::expected<control::Event, CommandError> RpcClient::next_event() {
  while (events_.empty()) {
    auto message = receive(Clock::time_point::max());
    if (!message) return std::unexpected(message.error());
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

std::expected<RpcClient::Message, CommandError> RpcClient::receive(Clock::time_point deadline) {
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
