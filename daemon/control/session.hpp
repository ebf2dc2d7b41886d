#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/json/value.hpp>
#include <deque>
#include <expected>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "daemon/control/control_server.hpp"
#include "proto/control/line_splitter.hpp"
#include "proto/control/request.hpp"

namespace truepose::daemon {

class Session;

/// What the sessions of one server share.
struct SessionContext {
  ControlServerParts parts;
  ControlLimits limits;
  std::string cell_name;
  std::string token;
  std::set<std::string, std::less<>> cell_methods;
  drivers::TimePoint started;
  std::string started_text;
  std::deque<drivers::TimePoint> hello_failures;
  std::set<Session*> sessions;  ///< those that live
};

/// One connection: a coroutine that reads and answers, and one that writes replies and events.
class Session : public std::enable_shared_from_this<Session> {
 public:
  using Result = std::expected<boost::json::value, control::RpcError>;

  /// Methods that sessions answer themselves.
  static const std::set<std::string, std::less<>>& own_methods();

  Session(boost::asio::ip::tcp::socket socket, std::shared_ptr<SessionContext> context);
  ~Session();

  void start();
  /// Says why instead of serving, and closes.
  void refuse(control::RpcError error);
  /// Closes at once and cancels the call under way.
  void stop();

 private:
  void spawn_writer();
  boost::asio::awaitable<void> read_requests();
  boost::asio::awaitable<void> discard_input();
  boost::asio::awaitable<void> write_lines();
  /// One read with a deadline. @return bytes read; 0 when the client or the time is gone
  boost::asio::awaitable<std::size_t> read_some(std::optional<drivers::TimePoint> deadline);
  boost::asio::awaitable<void> serve(std::string line);
  boost::asio::awaitable<Result> call(control::Request request);

  Result hello(const boost::json::object& params);
  Result system_info(const boost::json::object& params) const;
  Result subscribe(const boost::json::object& params);
  Result unsubscribe(const boost::json::object& params);

  std::optional<drivers::TimePoint> deadline() const;
  void see_events();
  std::string next_batch();
  void send(std::string line);
  /// Sends an error that belongs to no request, and closes once it is written.
  void dismiss(control::RpcError error);
  void close();

  boost::asio::ip::tcp::socket socket_;
  std::shared_ptr<SessionContext> context_;
  boost::asio::steady_timer wake_;     ///< cancelled when there is something to write
  boost::asio::steady_timer drained_;  ///< cancelled when something was written, and when the writer ended
  boost::asio::cancellation_signal cancel_;
  control::LineSplitter lines_;
  std::array<char, 4096> input_{};
  std::string outgoing_;  ///< replies not yet written
  std::unique_ptr<EventBus::Subscription> subscription_;
  drivers::TimePoint connected_;
  drivers::TimePoint last_request_;
  std::optional<drivers::TimePoint> line_started_;
  bool authenticated_ = false;
  bool finishing_ = false;  ///< write what is left, then close
  bool written_ = false;    ///< the writer has ended
};

}  // namespace truepose::daemon
