#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <expected>
#include <memory>
#include <string>
#include <vector>

#include "config/number_text.hpp"
#include "tools/proxy/route.hpp"

namespace truepose::proxy {

enum class Protocol { Udp, Tcp };

struct RouteOptions {
  Protocol protocol = Protocol::Udp;
  config::Endpoint listen;  ///< port 0 picks a free one
  config::Endpoint target;
};

/// "127.0.0.1:49152=192.168.44.1:49152". @return the route, or what was expected and found
std::expected<RouteOptions, std::string> parse_route(Protocol protocol, std::string_view text);

/// To a command: {"ok": true}, with the routes where statistics were asked for, or {"error": one sentence}.
struct Reply {
  std::string error{};
  std::optional<std::vector<RouteStatistics>> routes{};
};
void layout(record::Io& io, Reply& x);

/// Routes between devices, and what befalls their packets. Belongs to the thread of its executor.
class Proxy {
 public:
  /// @param seed  of all that happens by chance
  Proxy(boost::asio::any_io_executor executor, std::uint64_t seed);

  /// @return where it listens, or one sentence that names the address
  std::expected<std::string, std::string> add(const RouteOptions& options);

  Reply obey(const Command& command);
  /// Obeys each when its time has come, from now on.
  void follow(const std::vector<Command>& timeline);

  Statistics statistics() const;

 private:
  void await_next();

  boost::asio::any_io_executor executor_;
  std::uint64_t seed_;
  Random seeds_;
  std::vector<std::unique_ptr<Route>> routes_;
  std::deque<Command> timeline_;
  boost::asio::steady_timer timer_;
  boost::asio::steady_timer::time_point begun_{};
};

}  // namespace truepose::proxy
