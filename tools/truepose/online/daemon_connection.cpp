#include "tools/truepose/online/daemon_connection.hpp"

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
#include <optional>
#include <utility>

#include "config/number_text.hpp"
#include "config/text_file.hpp"

namespace truepose::tools {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

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
int try_connect(int socket, const addrinfo& address, Channel::Deadline until) {
  if (::connect(socket, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (!wait_for(socket, POLLOUT, until)) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

std::expected<DaemonConnection, CommandError> connect_over_tcp(const std::string& daemon,
                                                               const TlsFiles& tls) {
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
    const Channel::Deadline until = std::chrono::steady_clock::now() + kConnectPatience;
    error = socket < 0 ? errno : try_connect(socket, *address, until);
    if (error != 0) {
      if (socket >= 0) ::close(socket);
      continue;
    }
    if (tls.ca.empty()) return DaemonConnection{plain_channel(socket), daemon, endpoint_of(*address)};
    auto channel = tls_channel(socket, endpoint->host, tls, until);
    if (!channel) return std::unexpected(channel.error());
    return DaemonConnection{*std::move(channel), daemon, endpoint_of(*address)};
  }
  return std::unexpected(unreachable(daemon, std::strerror(error)));
}

/// Whether the process behind a control socket is the one that its folder belongs to. A folder that others
/// may write would let any user put a socket there.
std::optional<std::string> unexpected_server_behind(int socket, const fs::path& path) {
  ucred server{};
  socklen_t size = sizeof server;
  struct stat folder {};
  const fs::path parent = config::folder_of(path);
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
  if (const auto other_server = unexpected_server_behind(socket, path)) return failed(*other_server);
  return DaemonConnection{plain_channel(socket), path, {}};
}

/// The daemon of this machine, where there is one that lets us in.
std::expected<std::optional<DaemonConnection>, CommandError> connect_to_only_one() {
  const char* const user_folder = std::getenv("XDG_RUNTIME_DIR");
  std::optional<DaemonConnection> only;
  std::string names;
  for (const fs::path& path : control_sockets(user_folder ? user_folder : "", "/run/truepose")) {
    auto connected = connect_locally(path);
    if (!connected) continue;
    names += " " + path.string();
    if (!only) only = *std::move(connected);
  }
  if (names.find(' ', 1) == std::string::npos) return only;
  return std::unexpected(CommandError{kBadInput, "several cells run here; choose one by --daemon:" + names});
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

std::expected<DaemonConnection, CommandError> connect_to_daemon(const DaemonAddress& address) {
  if (address.daemon.find('/') != std::string::npos) return connect_locally(address.daemon);
  if (!address.daemon.empty()) return connect_over_tcp(address.daemon, address.tls);
  auto only = connect_to_only_one();
  if (!only) return std::unexpected(only.error());
  if (*only) return **std::move(only);
  return connect_over_tcp(kDefaultTcp, address.tls);
}

}  // namespace truepose::tools
