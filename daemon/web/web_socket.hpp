#pragma once

#include <algorithm>
#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "daemon/control/connection.hpp"
#include "daemon/threads/signal.hpp"
#include "proto/control/line_splitter.hpp"

namespace truepose::daemon {

/// A client over WebSocket: each of its text messages is a line for whoever reads here, and each line that is
/// written a text message for it. A message longer than a line may be is passed on in parts, as it comes, so
/// that the limits of lines hold for it.
///
/// @tparam Stream  a TCP socket, or TLS over one, whose handshake is done
template <typename Stream>
class WebSocketConnection final : public Connection {
 public:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  /// @param upgrade  what the client asked for the WebSocket by
  /// @param shown    the client's certificate
  /// @param kept     what the stream is made by
  WebSocketConnection(Stream stream, Request upgrade, std::optional<control::Certificate> shown,
                      std::shared_ptr<void> kept)
      : socket_{std::make_shared<Socket>(std::move(stream), std::move(kept))},
        upgrade_{std::move(upgrade)},
        shown_{std::move(shown)} {}
  ~WebSocketConnection() override { close(); }

  boost::asio::any_io_executor executor() override { return socket_->stream.get_executor(); }

  boost::asio::awaitable<std::expected<std::optional<control::Certificate>, std::string>> open() override {
    const auto [error] = co_await socket_->stream.async_accept(upgrade_, kAwaited);
    if (error) co_return std::unexpected(error.message());
    socket_->stream.text(true);
    boost::asio::co_spawn(executor(), pump(socket_), [](std::exception_ptr) {});
    co_return shown_;
  }

  boost::asio::awaitable<std::size_t> read_some(boost::asio::mutable_buffer buffer) override {
    Socket& socket = *socket_;
    while (socket.inbox.empty() && !socket.ended) co_await socket.filled.wait();
    const std::size_t size = std::min(buffer.size(), socket.inbox.size());
    std::copy_n(socket.inbox.begin(), size, static_cast<char*>(buffer.data()));
    socket.inbox.erase(0, size);
    socket.taken.notify();
    co_return size;
  }

  boost::asio::awaitable<bool> write(boost::asio::const_buffer bytes) override {
    std::string_view lines{static_cast<const char*>(bytes.data()), bytes.size()};
    while (!lines.empty()) {
      const std::string_view line = lines.substr(0, lines.find('\n'));
      const auto [error, size] = co_await socket_->stream.async_write(boost::asio::buffer(line), kAwaited);
      if (error) co_return false;
      lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    }
    co_return true;
  }

  boost::asio::awaitable<void> end_writing() override {
    const auto [gone] = co_await socket_->stream.async_close(socket_->farewell, kAwaited);
    static_cast<void>(gone);
  }
  void end_reading() override { socket_->end(); }
  void close() override {
    boost::system::error_code gone;
    boost::beast::get_lowest_layer(socket_->stream).close(gone);
    socket_->end();
  }

 private:
  static constexpr auto kAwaited = boost::asio::as_tuple(boost::asio::use_awaitable);

  struct Socket {
    Socket(Stream lower, std::shared_ptr<void> kept_with_it)
        : kept{std::move(kept_with_it)}, stream{std::move(lower)} {
      // The session has its own limits of time.
      stream.set_option(boost::beast::websocket::stream_base::timeout{
          std::chrono::seconds{5}, boost::beast::websocket::stream_base::none(), false});
      stream.auto_fragment(false);
    }
    void end() {
      ended = true;
      filled.notify();
      taken.notify();
    }

    std::shared_ptr<void> kept;
    boost::beast::websocket::stream<Stream> stream;
    std::string inbox{};  ///< came, and was not read yet
    Signal filled, taken;
    boost::beast::websocket::close_reason farewell{boost::beast::websocket::close_code::normal};
    bool ended = false;
  };

  /// Reads, a piece at a time, also while nobody takes it, since it is reading that answers pings; but no
  /// more ahead than a line may be long. A read of its own, since one that is cancelled takes the WebSocket
  /// with it, and then no reason could be written.
  static boost::asio::awaitable<void> pump(std::shared_ptr<Socket> socket) {
    std::array<char, 4096> piece;
    while (!socket->ended) {
      const auto [error, size] =
          co_await socket->stream.async_read_some(boost::asio::buffer(piece), kAwaited);
      if (error) break;
      if (!socket->stream.got_text()) {
        socket->farewell = {boost::beast::websocket::close_code::unknown_data,
                            "messages are text here, not binary"};
        break;
      }
      // A message is one line, however its JSON is laid out.
      std::replace_if(
          piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(size),
          [](char byte) { return byte == '\n' || byte == '\r'; }, ' ');
      socket->inbox.append(piece.data(), size);
      if (socket->stream.is_message_done()) socket->inbox += '\n';
      socket->filled.notify();
      while (socket->inbox.size() > control::kMaxLine && !socket->ended) co_await socket->taken.wait();
    }
    socket->end();
  }

  std::shared_ptr<Socket> socket_;
  Request upgrade_;
  std::optional<control::Certificate> shown_;
};

}  // namespace truepose::daemon
