#pragma once

#include <chrono>
#include <expected>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/truepose/exit_code.hpp"

namespace truepose::tools {

/// Why a command ends without its result.
struct ClientError {
  int exit_code = kFailed;
  std::string message;  ///< one sentence
};

/// A connection to a daemon, not yet a session.
struct DaemonConnection {
  int socket = -1;       ///< the caller's to close
  std::string daemon;    ///< for messages
  std::string endpoint;  ///< "127.0.0.1 7210" over TCP; empty over a control socket
};

/// Control sockets of this machine's daemons: those of the calling user, then those of the system.
std::vector<std::filesystem::path> control_sockets(const std::filesystem::path& user_folder,
                                                   const std::filesystem::path& system_folder);

/// Connects to a daemon.
///
/// @param daemon  "127.0.0.1:7210", "[::1]:7210", or a control socket's path, which has a slash; empty: the
/// control
///                socket of the one daemon that runs here, else 127.0.0.1:7210
/// Errors: kBadInput for an address that cannot be read, or several daemons to choose from; kUnreachable
/// where nobody answers, and for a control socket that is not served by the owner of its folder.
std::expected<DaemonConnection, ClientError> connect_to_daemon(const std::string& daemon);

/// Waits for a socket. @return false when the time is over
bool wait_for(int socket, short events, std::chrono::steady_clock::time_point deadline);

}  // namespace truepose::tools
