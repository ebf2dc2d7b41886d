#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ssl/context.hpp>
#include <cstddef>
#include <expected>
#include <memory>
#include <optional>
#include <string>

#include "drivers/net/stream.hpp"
#include "proto/control/certificate.hpp"

namespace truepose::daemon {

/// Who is at the other end.
struct Peer {
  std::string name;      ///< "uid 1000" over the Unix socket, else the address; whom limits are counted for
  std::string endpoint;  ///< of TCP: "127.0.0.1 7210", where the client found us
  bool trusted = false;  ///< let in by the Unix socket's owner and mode: needs no token

  /// Of a connection over TCP. Has the kernel ask after some silence whether the other end is still there.
  static Peer of(const net::Stream& stream);
};

/// A way to a client. One read and one write may be under way at a time; every wait can be cancelled.
class Connection {
 public:
  virtual ~Connection() = default;

  virtual boost::asio::any_io_executor executor() = 0;
  /// What comes before the first byte. @return what the client showed of itself; else one phrase
  virtual boost::asio::awaitable<std::expected<std::optional<control::Certificate>, std::string>> open() = 0;
  /// @return bytes read; 0 when the client is gone
  virtual boost::asio::awaitable<std::size_t> read_some(boost::asio::mutable_buffer buffer) = 0;
  /// @return false when the client is gone
  virtual boost::asio::awaitable<bool> write(boost::asio::const_buffer bytes) = 0;
  /// Tells the client that nothing more comes.
  virtual boost::asio::awaitable<void> end_writing() = 0;
  /// Ends the read under way.
  virtual void end_reading() = 0;
  virtual void close() = 0;
};

/// In the clear, over TCP or a Unix socket.
std::unique_ptr<Connection> plain_connection(std::unique_ptr<net::Stream> stream);

/// Over TLS. The client's certificate is only proven to be its own: whether it may come in is not judged
/// here.
/// @param stream  over TCP
std::unique_ptr<Connection> tls_connection(std::unique_ptr<net::Stream> stream,
                                           std::shared_ptr<boost::asio::ssl::context> identity);

}  // namespace truepose::daemon
