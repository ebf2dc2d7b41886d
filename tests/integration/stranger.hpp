#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

namespace truepose {

/// How a stranger comes to a port.
struct Way {
  std::string from, to;  ///< addresses
  std::uint16_t port = 0;
  bool over_tls = false;  ///< he goes as far as he can without being known
};

/// Somebody that no daemon knows, with one connection at a time.
class Stranger {
 public:
  explicit Stranger(Way way) : way_{std::move(way)} {}

  /// Reconnects if the connection was lost. @return whether it is connected
  bool connect();
  void send(std::string_view bytes);
  void hang_up();

 private:
  using Socket = boost::asio::ip::tcp::socket;

  bool ended();

  Way way_;
  boost::asio::io_context context_;
  boost::asio::ssl::context tls_context_{boost::asio::ssl::context::tls_client};
  std::optional<Socket> socket_;
  std::optional<boost::asio::ssl::stream<Socket&>> tls_;
};

// Attacks continue until a stop is requested. @return their number

/// Of 200 connections that stay, each gets these bytes ten times a second.
std::uint64_t hold_200(const Way& way, std::string_view bytes, const std::stop_token& stop);
std::uint64_t connect_again_and_again(const Way& way, const std::stop_token& stop);
std::uint64_t send_lines_of_1_MB(const Way& way, const std::stop_token& stop);

}  // namespace truepose
