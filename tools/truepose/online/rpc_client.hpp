#pragma once

#include <boost/json/value.hpp>
#include <chrono>
#include <deque>
#include <expected>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "proto/control/line_splitter.hpp"
#include "proto/control/request.hpp"
#include "proto/record/json_io.hpp"
#include "proto/rpc/session.hpp"
#include "tools/truepose/command_line.hpp"
#include "tools/truepose/online/daemon_connection.hpp"

namespace truepose::tools {

/// What the daemon sent: as it came, and as the record that it is.
template <class Record>
struct Received {
  boost::json::value json;
  Record record;
};

/// Reads what the daemon sent. A newer one may send more members.
/// @param what  method or event, which the error names
template <class Record>
std::expected<Received<Record>, CommandError> received(boost::json::value json, std::string_view what) {
  auto record = record::from_json<Record>(json);
  if (record) return Received<Record>{std::move(json), *std::move(record)};
  return std::unexpected(
      CommandError{kFailed, std::string{what} + ": the daemon's answer cannot be read: " + record.error()});
}

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
  std::expected<boost::json::value, CommandError> call(std::string_view method,
                                                       const boost::json::object& params,
                                                       std::chrono::seconds patience = kPatience);
  template <rpc::Request R>
  std::expected<Received<typename R::Result>, CommandError> call(const R& request,
                                                                 std::chrono::seconds patience = kPatience) {
    return call_with<R>(record::to_json(request), patience);
  }
  /// The same with parameters of which those that are left out have the daemon's defaults.
  template <rpc::Request R>
  std::expected<Received<typename R::Result>, CommandError> call_with(
      const boost::json::object& params, std::chrono::seconds patience = kPatience) {
    auto answer = call(R::method().name, params, patience);
    if (!answer) return std::unexpected(std::move(answer.error()));
    return received<typename R::Result>(*std::move(answer), R::method().name);
  }
  /// The next event, however long it takes, or kFailed where none comes within the patience.
  std::expected<control::Event, CommandError> next_event(
      std::optional<std::chrono::duration<double>> patience = {});

 private:
  using Message = control::ServerMessage;
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kPatience{180};

  RpcClient(std::unique_ptr<Channel> channel, std::string daemon)
      : channel_{std::move(channel)}, daemon_{std::move(daemon)} {}
  std::expected<boost::json::value, CommandError> hello(rpc::SessionHello request);
  std::expected<boost::json::value, CommandError> open_by_token(const std::string& endpoint,
                                                                const DaemonAddress& address);
  std::expected<boost::json::value, CommandError> open_by_proof(const std::string& endpoint,
                                                                const std::string& token);
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
