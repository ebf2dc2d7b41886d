#include "drivers/net/socket_stream.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <cstring>
#include <utility>

namespace truepose::net {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

void set(const Stream& stream, int level, int option, int value) {
  ::setsockopt(stream.handle(), level, option, &value, sizeof value);
}

/// So that a device that has lost its power is noticed within about 5 s.
void probe(const Stream& stream) {
  keep_alive(stream, 2, 1, 3);
  set(stream, IPPROTO_TCP, TCP_USER_TIMEOUT, 5000);  // ms until what was sent must be confirmed
}

}  // namespace

asio::awaitable<error_code> SocketStream::connect(std::string host, std::uint16_t port) {
  close();
  tcp::resolver resolver{socket_.get_executor()};
  auto [resolve_error, found] = co_await resolver.async_resolve(host, std::to_string(port), kAsTuple);
  if (resolve_error) co_return resolve_error;
  error_code error = asio::error::host_not_found;
  for (const auto& each : found) {
    close();
    const auto [refused] = co_await socket_.async_connect(each.endpoint(), kAsTuple);
    error = refused;
    if (!error || error == asio::error::operation_aborted) break;
  }
  if (error) co_return error;
  send_at_once(*this);
  probe(*this);
  co_return error;
}

asio::awaitable<Stream::Received> SocketStream::read(std::span<char> into) {
  const auto [error, size] =
      co_await socket_.async_read_some(asio::buffer(into.data(), into.size()), kAsTuple);
  co_return Received{error, size};
}

asio::awaitable<error_code> SocketStream::write(std::string_view bytes) {
  const auto [error, size] = co_await asio::async_write(socket_, asio::buffer(bytes), kAsTuple);
  co_return error;
}

asio::awaitable<void> SocketStream::end_writing() {
  error_code gone;
  socket_.shutdown(asio::socket_base::shutdown_send, gone);
  co_return;
}

void SocketStream::end_reading() {
  error_code gone;
  socket_.shutdown(asio::socket_base::shutdown_receive, gone);
}

void SocketStream::close() noexcept {
  error_code ignored;
  socket_.close(ignored);
}

Stream::End SocketStream::local() const {
  error_code unknown;
  return end_of(socket_.local_endpoint(unknown));
}
Stream::End SocketStream::remote() const {
  error_code unknown;
  return end_of(socket_.remote_endpoint(unknown));
}

int SocketStream::handle() const { return socket_.is_open() ? socket_.native_handle() : -1; }

Stream::End end_of(const asio::generic::stream_protocol::endpoint& endpoint) {
  const int family = endpoint.data()->sa_family;
  if (family != AF_INET && family != AF_INET6) return {};
  tcp::endpoint of_tcp;
  of_tcp.resize(endpoint.size());
  std::memcpy(of_tcp.data(), endpoint.data(), endpoint.size());
  return {of_tcp.address().to_string(), of_tcp.port()};
}

std::unique_ptr<Stream> tcp_stream(asio::any_io_executor executor) {
  return std::make_unique<SocketStream>(SocketStream::Socket{std::move(executor)});
}

void keep_alive(const Stream& stream, int silence_s, int again_s, int times) {
  set(stream, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(stream, IPPROTO_TCP, TCP_KEEPIDLE, silence_s);
  set(stream, IPPROTO_TCP, TCP_KEEPINTVL, again_s);
  set(stream, IPPROTO_TCP, TCP_KEEPCNT, times);
}

void send_at_once(const Stream& stream) { set(stream, IPPROTO_TCP, TCP_NODELAY, 1); }

bool has_left(const Stream& stream) {
  char byte = 0;
  return ::recv(stream.handle(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

std::size_t read_waiting(const Stream& stream, std::span<char> into) {
  const ssize_t size = ::recv(stream.handle(), into.data(), into.size(), MSG_DONTWAIT);
  return size > 0 ? static_cast<std::size_t>(size) : 0;
}

void close_in_order(Stream& stream) noexcept {
  ::shutdown(stream.handle(), SHUT_RDWR);
  stream.close();
}

void reset(Stream& stream) noexcept {
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  ::setsockopt(stream.handle(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  stream.close();
}

}  // namespace truepose::net
