#pragma once

#include <boost/json/value.hpp>
#include <chrono>
#include <deque>
#include <expected>
#include <memory>
#include <string>
#include <variant>

#include "proto/control/line_splitter.hpp"
#include "proto/control/request.hpp"
#include "tools/truepose/command_line.hpp"
#include "tools/truepose/online/daemon_connection.hpp"

namespace truepose::tools {

/// A blocking client of the daemon's control protocol.
class RpcClient {
 public:
  /// Connects and opens the session: over TCP by a proof that both ends know the token, which is not sent
  /// itself; over TLS by the client's certificate, else by the token; over a control socket without one.
  ///
  /// Errors: those of connect_to_daemon(); kBadInput for a token file that cannot be read and where the
  /// daemon does not know the client; kUnreachable for a daemon that does not know the token.
  static std::expected<RpcClient, CommandError> connect(const DaemonAddress& address);

  /// Calls and waits for the answer. Events that come meanwhile are kept for next_event().
  std::expected<boost::json::value, CommandError> call(const std::string& method,
                                                       const boost::json::object& params,
                                                       std::chrono::seconds patience = std::chrono::seconds{
                                                           180});
  /// The next event, however long it takes.
  std::expected<control::Event, CommandError> next_event();

 private:
  using Message = control::ServerMessage;
  using Clock = std::chrono::steady_clock;

  RpcClient(std::unique_ptr<Channel> channel, std::string daemon)
      : channel_{std::move(channel)}, daemon_{std::move(daemon)} {}
  std::expected<void, CommandError> open_unasked();
  std::expected<void, CommandError> open_by_token(const std::string& endpoint, const DaemonAddress& address);
  std::expected<void, CommandError> open_by_proof(const std::string& endpoint, const std::string& token);
  std::expected<void, CommandError> send(const std::string& line);
  std::expected<Message, CommandError> receive(Clock::time_point deadline);
  CommandError lost(const std::string& why) const;

  std::unique_ptr<Channel> channel_;
  std::string daemon_;
  control::LineSplitter lines_{control::kMaxLine};
  std::deque<control::Event> events_;
  std::int64_t last_id_ = 0;
};

}  // namespace truepose::tools
