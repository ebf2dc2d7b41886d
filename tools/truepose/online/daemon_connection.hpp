#pragma once

#include <expected>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tools/truepose/command_line.hpp"
#include "tools/truepose/online/channel.hpp"

namespace truepose::tools {

/// Where a daemon is, and by what it and the client know each other.
struct DaemonAddress {
  std::string daemon;  ///< "127.0.0.1:7210", "[::1]:7210", or a control socket's path, which has a slash;
                       ///< empty: the control socket of the one daemon that runs here, else 127.0.0.1:7210
  std::filesystem::path token_file;
  TlsFiles tls{};  ///< for HOST:PORT
};

/// Control sockets of this machine's daemons: those of the calling user, then those of the system.
std::vector<std::filesystem::path> control_sockets(const std::filesystem::path& user_folder,
                                                   const std::filesystem::path& system_folder);

/// A connection to a daemon, not yet a session.
struct DaemonConnection {
  std::unique_ptr<Channel> channel;
  std::string daemon;    ///< for messages
  std::string endpoint;  ///< "127.0.0.1 7210" over TCP; empty over a control socket
};

/// Errors: kBadInput for an address or a file that cannot be used and several daemons to choose from,
/// kUnreachable where no daemon answers, for a control socket that is not served by the owner of its folder
/// and for a daemon whose certificate does not hold.
std::expected<DaemonConnection, CommandError> connect_to_daemon(const DaemonAddress& address);

}  // namespace truepose::tools
