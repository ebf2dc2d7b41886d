#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <utility>

#include "drivers/byte_stream.hpp"
#include "proto/text/host_port.hpp"

namespace truepose::drivers {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

constexpr auto kAsTuple = asio::as_tuple(asio::use_awaitable);

void keep_alive(tcp::socket& socket) {
  const auto set = [&socket](int level, int option, int value) {
    ::setsockopt(socket.native_handle(), level, option, &value, sizeof value);
  };
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 2);   // s of silence before the first probe
  set(IPPROTO_TCP, TCP_KEEPINTVL, 1);  // s between probes
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
  set(IPPROTO_TCP, TCP_USER_TIMEOUT, 5000);  // ms until what was sent must be confirmed
}

class TcpStream final : public ByteStream {
 public:
  explicit TcpStream(asio::any_io_executor executor) : socket_{std::move(executor)} {}

  asio::awaitable<error_code> connect(std::string host, std::uint16_t port) override {
    close();
    tcp::resolver resolver{socket_.get_executor()};
    const std::string service = std::to_string(port);
    auto [resolve_error, endpoints] = co_await resolver.async_resolve(host, service, kAsTuple);
    if (resolve_error) co_return resolve_error;
    auto [error, endpoint] = co_await asio::async_connect(socket_, endpoints, kAsTuple);
    if (error) co_return error;
    error_code ignored;
    socket_.set_option(tcp::no_delay{true}, ignored);
    keep_alive(socket_);
    co_return error;
  }

  asio::awaitable<Received> read(std::span<char> into) override {
    auto [error, size] = co_await socket_.async_read_some(asio::buffer(into.data(), into.size()), kAsTuple);
    co_return Received{error, size};
  }

  asio::awaitable<error_code> write(std::string_view bytes) override {
    auto [error, size] = co_await asio::async_write(socket_, asio::buffer(bytes), kAsTuple);
    co_return error;
  }

  void close() noexcept override {
    error_code ignored;
    socket_.close(ignored);
  }
  bool is_open() const override { return socket_.is_open(); }
  std::string ends() const override {
    error_code no_local, no_remote;
    const tcp::endpoint local = socket_.local_endpoint(no_local), remote = socket_.remote_endpoint(no_remote);
    if (no_local || no_remote) return {};
    return text::host_port(local.address().to_string(), local.port()) + ' ' +
           text::host_port(remote.address().to_string(), remote.port());
  }

 private:
  tcp::socket socket_;
};

}  // namespace

std::unique_ptr<ByteStream> tcp_stream(asio::any_io_executor executor) {
  return std::make_unique<TcpStream>(std::move(executor));
}

}  // namespace truepose::drivers
