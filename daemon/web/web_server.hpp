#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/address.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "config/cell_config.hpp"
#include "daemon/control/control_server.hpp"
#include "daemon/web/health.hpp"
#include "drivers/clock.hpp"
#include "drivers/net/network.hpp"
#include "drivers/start_failure.hpp"

namespace truepose::daemon {

/// What one client, or many, may take.
struct WebLimits {
  std::size_t connections = 32;                  ///< beyond, the one that has waited longest is closed
  std::chrono::milliseconds handshake{5'000};    ///< from connecting to the end of the first request's header
  std::chrono::milliseconds idle{60'000};        ///< from an answer to the end of the next request's header
  std::chrono::milliseconds write_stall{5'000};  ///< a client that takes nothing for so long is gone
};

/// What the server works with. All of it outlives the server and the event loop that it runs on.
struct WebServerParts {
  drivers::Clock& clock;
  ControlServer& control;
  std::function<Health()> health;
  std::function<std::string()> metrics;  ///< in the text format of Prometheus
  std::function<void(const std::string&)> warn;
  net::Network network{};  ///< where it listens
};

/// The address of web.listen, and whether it speaks TLS.
struct WebAddress {
  boost::asio::ip::address address;
  bool tls = false;
};
/// @param has_tls  the cell file has control.tls
/// @return it, or why the server cannot be there and what to do
std::expected<WebAddress, std::string> web_address(const config::Endpoint& listen, bool has_tls);

/// Serves over HTTP/1.1 the dashboard (/), the metrics (/metrics), the health (/healthz) and, over WebSocket,
/// the control protocol (/rpc), whose sessions are those of the control server. On loopback in the clear,
/// elsewhere over TLS with the control port's certificate; there metrics and health need a token too
/// ("Authorization: Bearer ...") or a known certificate. Runs on one thread: the executor's.
class WebServer {
 public:
  /// Binds and listens: who connects waits for serve().
  static std::expected<std::unique_ptr<WebServer>, drivers::StartFailure> start(
      boost::asio::any_io_executor executor, WebServerParts parts, const config::WebConfig& config,
      WebLimits limits = {});
  ~WebServer();

  /// Starts to accept.
  void serve();
  std::uint16_t port() const;
  /// Connections that are no session of the control server.
  std::size_t connections() const;
  /// Accepts no more and closes every connection that is no session of the control server.
  void stop();

 private:
  struct Impl;
  explicit WebServer(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

}  // namespace truepose::daemon
