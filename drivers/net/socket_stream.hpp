#pragma once

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "drivers/net/stream.hpp"

namespace truepose::net {

/// Has an operation return its error as a value.
inline constexpr auto kAsTuple = boost::asio::as_tuple(boost::asio::use_awaitable);

/// A stream over a socket of the system: TCP or Unix.
class SocketStream final : public Stream {
 public:
  using Socket = boost::asio::generic::stream_protocol::socket;

  explicit SocketStream(Socket socket) : socket_{std::move(socket)} {}

  boost::asio::any_io_executor executor() override { return socket_.get_executor(); }
  boost::asio::awaitable<boost::system::error_code> connect(std::string host, std::uint16_t port) override;
  boost::asio::awaitable<Received> read(std::span<char> into) override;
  boost::asio::awaitable<boost::system::error_code> write(std::string_view bytes) override;
  boost::asio::awaitable<void> end_writing() override;
  void end_reading() override;
  void close() noexcept override;
  bool is_open() const override { return socket_.is_open(); }
  End local() const override;
  End remote() const override;
  int handle() const override;

  /// What the stream stands on, for one that takes its place.
  Socket release() { return std::move(socket_); }

 private:
  mutable Socket socket_;
};

/// As End, of an endpoint of TCP.
Stream::End end_of(const boost::asio::generic::stream_protocol::endpoint& endpoint);

}  // namespace truepose::net
