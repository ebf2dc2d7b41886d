#pragma once

#include <chrono>
#include <expected>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

/// A blocking way to the daemon. Errors are one phrase.
class Channel {
 public:
  using Deadline = std::chrono::steady_clock::time_point;

  virtual ~Channel() = default;
  virtual std::expected<void, std::string> write(std::string_view bytes, Deadline until) = 0;
  /// @return bytes read, at least one
  virtual std::expected<std::size_t, std::string> read_some(std::span<char> bytes, Deadline until) = 0;
};

/// Waits for a socket. @return false when the time is over
bool wait_for(int socket, short events, Channel::Deadline until);

/// Takes a socket that does not block, and closes it at its end.
std::unique_ptr<Channel> plain_channel(int socket);

/// By what a client knows the daemon over TLS, and the daemon the client. PEM files; none: not over TLS.
struct TlsFiles {
  std::filesystem::path ca;                ///< whom the daemon's certificate has to be from
  std::filesystem::path certificate, key;  ///< the client's own; none: by token
};

/// The same over TLS 1.3. The daemon's certificate must be of the CA and name `host`, a name or an IP
/// address. Errors: kBadInput for a file that cannot be used, kUnreachable where no TLS comes about.
std::expected<std::unique_ptr<Channel>, CommandError> tls_channel(int socket, const std::string& host,
                                                                  const TlsFiles& files,
                                                                  Channel::Deadline until);

}  // namespace truepose::tools
