#include "daemon/control/connection.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <utility>

namespace truepose::daemon {

namespace {

namespace asio = boost::asio;
using asio::awaitable;
using asio::ip::tcp;
using Opened = std::expected<std::optional<control::Certificate>, std::string>;

constexpr auto kAwaited = asio::as_tuple(asio::use_awaitable);

template <typename Stream>
awaitable<std::size_t> read_some_of(Stream& stream, asio::mutable_buffer buffer) {
  const auto [error, size] = co_await stream.async_read_some(buffer, kAwaited);
  co_return error ? 0 : size;
}

template <typename Stream>
awaitable<bool> write_to(Stream& stream, asio::const_buffer bytes) {
  const auto [error, size] = co_await asio::async_write(stream, bytes, kAwaited);
  co_return !error;
}

/// Both ends of the way first: a client that still sends sees an end, not a reset.
void close_ways(auto& socket) {
  boost::system::error_code gone;
  socket.shutdown(asio::socket_base::shutdown_both, gone);
  socket.close(gone);
}

class PlainConnection final : public Connection {
 public:
  explicit PlainConnection(asio::generic::stream_protocol::socket socket) : socket_{std::move(socket)} {}

  asio::any_io_executor executor() override { return socket_.get_executor(); }
  awaitable<Opened> open() override { co_return Opened{}; }
  awaitable<std::size_t> read_some(asio::mutable_buffer buffer) override {
    return read_some_of(socket_, buffer);
  }
  awaitable<bool> write(asio::const_buffer bytes) override { return write_to(socket_, bytes); }
  awaitable<void> end_writing() override {
    boost::system::error_code gone;
    socket_.shutdown(asio::socket_base::shutdown_send, gone);
    co_return;
  }
  void end_reading() override {
    boost::system::error_code gone;
    socket_.shutdown(asio::socket_base::shutdown_receive, gone);
  }
  void close() override { close_ways(socket_); }

 private:
  asio::generic::stream_protocol::socket socket_;
};

class TlsConnection final : public Connection {
 public:
  TlsConnection(tcp::socket socket, std::shared_ptr<asio::ssl::context> identity)
      : identity_{std::move(identity)}, stream_{std::move(socket), *identity_} {}

  asio::any_io_executor executor() override { return stream_.get_executor(); }
  awaitable<Opened> open() override {
    const auto [error] = co_await stream_.async_handshake(asio::ssl::stream_base::server, kAwaited);
    if (error) co_return std::unexpected(error.message());
    const X509* const shown = SSL_get0_peer_certificate(stream_.native_handle());
    if (!shown) co_return Opened{};
    co_return control::facts_of(*shown);
  }
  awaitable<std::size_t> read_some(asio::mutable_buffer buffer) override {
    return read_some_of(stream_, buffer);
  }
  awaitable<bool> write(asio::const_buffer bytes) override { return write_to(stream_, bytes); }
  awaitable<void> end_writing() override {
    const auto said = co_await stream_.async_shutdown(kAwaited);
    static_cast<void>(said);
  }
  void end_reading() override {
    boost::system::error_code gone;
    stream_.next_layer().shutdown(asio::socket_base::shutdown_receive, gone);
  }
  void close() override { close_ways(stream_.next_layer()); }

 private:
  std::shared_ptr<asio::ssl::context> identity_;  ///< outlives one that takes its place meanwhile
  asio::ssl::stream<tcp::socket> stream_;
};

/// A client whose machine was switched off says nothing of it, and events alone may come after hours.
void keep_alive(tcp::socket& socket) {
  constexpr int kSilence_s = 30, kAgain_s = 10, kTimes = 3;
  const auto set = [&socket](int level, int option, int value) {
    ::setsockopt(socket.native_handle(), level, option, &value, sizeof value);
  };
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, kSilence_s);
  set(IPPROTO_TCP, TCP_KEEPINTVL, kAgain_s);
  set(IPPROTO_TCP, TCP_KEEPCNT, kTimes);
}

}  // namespace

Peer Peer::of(tcp::socket& socket) {
  boost::system::error_code gone;
  const tcp::endpoint theirs = socket.remote_endpoint(gone), ours = socket.local_endpoint(gone);
  keep_alive(socket);
  const asio::ip::address address = theirs.address();
  // Every user of this machine has all of its loopback addresses.
  return {address.is_loopback() ? "loopback" : address.to_string(),
          ours.address().to_string() + " " + std::to_string(ours.port())};
}

std::unique_ptr<Connection> plain_connection(asio::generic::stream_protocol::socket socket) {
  return std::make_unique<PlainConnection>(std::move(socket));
}

std::unique_ptr<Connection> tls_connection(tcp::socket socket, std::shared_ptr<asio::ssl::context> identity) {
  return std::make_unique<TlsConnection>(std::move(socket), std::move(identity));
}

}  // namespace truepose::daemon
