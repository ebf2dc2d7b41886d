#pragma once

#include <boost/json/value.hpp>
#include <chrono>
#include <deque>
#include <expected>
#include <filesystem>
#include <string>

#include "proto/control/line_splitter.hpp"
#include "proto/control/request.hpp"
#include "tools/truepose/daemon_connection.hpp"

namespace truepose::tools {

/// A blocking client of the daemon's control protocol.
class RpcClient {
 public:
  /// Connects and opens the session: over TCP by a proof that both ends know the token, which is not sent
  /// itself; over a control socket without one. Errors: those of connect_to_daemon(); kBadInput for a token
  /// file that cannot be read and a wrong token; kUnreachable for a daemon that does not know the token.
  /// @param daemon  as connect_to_daemon() takes it
  static std::expected<RpcClient, ClientError> connect(const std::string& daemon,
                                                       const std::filesystem::path& token_file);
  RpcClient(RpcClient&& other) noexcept;
  RpcClient& operator=(RpcClient&&) = delete;
  ~RpcClient();

  /// Calls and waits for the answer. Events that come meanwhile are kept for next_event().
  std::expected<boost::json::value, ClientError> call(const std::string& method,
                                                      const boost::json::object& params,
                                                      std::chrono::seconds patience = std::chrono::seconds{
                                                          180});
  /// The next event, however long it takes.
  std::expected<control::Event, ClientError> next_event();

 private:
  using Message = std::variant<control::Reply, control::Event>;
  using Clock = std::chrono::steady_clock;

  RpcClient(int socket, std::string daemon) : socket_{socket}, daemon_{std::move(daemon)} {}
  std::expected<void, ClientError> open_locally();
  std::expected<void, ClientError> open_by_proof(const std::string& endpoint,
                                                 const std::filesystem::path& token_file);
  std::expected<void, ClientError> send(const std::string& line);
  std::expected<Message, ClientError> receive(Clock::time_point deadline);
  ClientError lost(const std::string& why) const;

  int socket_;
  std::string daemon_;
  control::LineSplitter lines_{control::kMaxLine};
  std::deque<control::Event> events_;
  std::int64_t last_id_ = 0;
};

}  // namespace truepose::tools
