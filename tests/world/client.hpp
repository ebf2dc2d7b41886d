#pragma once

#include <algorithm>
#include <boost/asio/awaitable.hpp>
#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/threads/signal.hpp"
#include "tests/world/world.hpp"

namespace truepose::world {

/// A request of a client, and what became of it.
struct Request {
  std::string method{};
  boost::json::object params{};
  drivers::TimePoint asked{}, answered{};
  boost::json::value answer{};  ///< with `result` or `error`; null: none yet, or the session ended before
};

/// A client of the control port: an HMI, a script, or a person at the command line.
///
/// It speaks the protocol by itself, and checks of each session what every client relies on: an answer for
/// each request, and all events in order.
class Client {
 public:
  /// @param topics  of the events that it subscribes to; empty: all
  Client(World& world, std::string name, std::string token, boost::json::array topics = {});
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Opens a session and subscribes, missed events included. @return whether it is open
  boost::asio::awaitable<bool> connect();
  const std::string& name() const { return name_; }
  /// Ends the subscription, and subscribes to all events since. @return whether it could
  boost::asio::awaitable<bool> subscribe_again();
  bool is_connected() const;
  void disconnect();
  /// Disconnects after the first bytes of a request.
  boost::asio::awaitable<void> disconnect_within_a_line();
  /// Reads nothing more before then, of whatever session.
  void read_again_at(drivers::TimePoint then) { reads_at_ = std::max(reads_at_, then); }
  /// Whether it would see that its session has ended.
  bool reads() const { return world_.clock.now() >= reads_at_; }
  /// Name and role that the daemon knows the client by, since its first session; empty before.
  const std::string& user() const { return user_; }
  const std::string& role() const { return role_; }

  /// The answer of one request: `result`, or `error`; null where the session ended before.
  boost::asio::awaitable<boost::json::value> ask(std::string method, boost::json::object params = {});

  std::function<void(const boost::json::object& event)> on_event = [](const boost::json::object&) {};
  /// Whether an event is one of before the session, which comes late.
  bool is_late(const boost::json::object& event) const;
  /// Each request as it is sent, and once it is answered or its session has ended.
  std::function<void(const Request&)> on_request = [](const Request&) {};
  std::function<void(const Request&)> on_answer = [](const Request&) {};
  /// By this answer of events.subscribe.
  std::function<void(const boost::json::object& answer)> on_subscribed = [](const boost::json::object&) {};
  /// A session is open, or has ended.
  std::function<void(bool is_open)> on_session = [](bool) {};
  /// What broke a promise of the protocol.
  std::vector<std::string> complaints;

 private:
  struct Session;
  static boost::asio::awaitable<void> read(Client& client, std::shared_ptr<Session> session);
  boost::asio::awaitable<boost::json::object> credentials();
  boost::asio::awaitable<bool> subscribe();
  void take(Session& session, const std::string& line);

  World& world_;
  std::string name_, token_, user_, role_;
  boost::json::array topics_;
  drivers::TimePoint reads_at_{};
  std::shared_ptr<Session> session_;
  std::uint64_t seq_ = 0;  // of the last event
  int proofs_ = 0;
};

}  // namespace truepose::world
