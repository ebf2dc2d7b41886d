#pragma once

#include <boost/json/value.hpp>
#include <chrono>
#include <deque>
#include <expected>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "proto/control/line_splitter.hpp"
#include "proto/control/request.hpp"
#include "tools/truepose/command_line.hpp"

namespace truepose::tools {

/// Control sockets of this machine's daemons: those of the calling user, then those of the system.
std::vector<std::filesystem::path> control_sockets(const std::filesystem::path& user_folder,
                                                   const std::filesystem::path& system_folder);

/// A blocking client of the daemon's control protocol.
class RpcClient {
 public:
  /// Connects and opens the session: over TCP by a proof that both ends know the token, which is not sent
  /// itself; over a control socket without one.
  ///
  /// @param daemon  "127.0.0.1:7210", "[::1]:7210", or a control socket's path, which has a slash; empty: the
  ///                control socket of the one daemon that runs here, else 127.0.0.1:7210
  /// Errors: kBadInput for an address that cannot be read, several daemons to choose from, a token file that
  /// cannot be read and a wrong token; kUnreachable where nobody answers, for a control socket that is not
  /// served by the owner of its folder, and for a daemon that does not know the token.
  static std::expected<RpcClient, CommandError> connect(const std::string& daemon,
                                                        const std::filesystem::path& token_file);
  RpcClient(RpcClient&& other) noexcept;
  RpcClient& operator=(RpcClient&&) = delete;
  ~RpcClient();

  /// Calls and waits for the answer. Events that come meanwhile are kept for next_event().
  std::expected<boost::json::value, CommandError> call(const std::string& method,
                                                       const boost::json::object& params,
                                                       std::chrono::seconds patience = std::chrono::seconds{
                                                           180});
  /// The next event, however long it takes.
  std::expected<control::Event, CommandError> next_event();

 private:
  using Message = std::variant<control::Reply, control::Event>;
  using Clock = std::chrono::steady_clock;

  RpcClient(int socket, std::string daemon) : socket_{socket}, daemon_{std::move(daemon)} {}
  std::expected<void, CommandError> open_locally();
  std::expected<void, CommandError> open_by_proof(const std::string& endpoint,
                                                  const std::filesystem::path& token_file);
  std::expected<void, CommandError> send(const std::string& line);
  std::expected<Message, CommandError> receive(Clock::time_point deadline);
  CommandError lost(const std::string& why) const;

  int socket_;
  std::string daemon_;
  control::LineSplitter lines_{control::kMaxLine};
  std::deque<control::Event> events_;
  std::int64_t last_id_ = 0;
};

}  // namespace truepose::tools
