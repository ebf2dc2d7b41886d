#include "daemon/web/web_socket.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/associated_cancellation_slot.hpp>
#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <functional>
#include <utility>

#include "daemon/threads/signal.hpp"
#include "drivers/net/spawn.hpp"
#include "proto/control/line_splitter.hpp"

namespace truepose::daemon {

namespace {

namespace asio = boost::asio;
namespace websocket = boost::beast::websocket;
using asio::awaitable;
using boost::system::error_code;

constexpr auto kAwaited = asio::as_tuple(asio::use_awaitable);

/// A connection as the stream that Beast's WebSocket stands on. Beast calls it with handlers alone, which
/// take the same way whatever their types are.
class Carrier {
 public:
  using executor_type = asio::any_io_executor;

  Carrier(std::shared_ptr<Connection> connection, std::string come)
      : connection_{std::move(connection)}, come_{std::move(come)} {}

  executor_type get_executor() { return connection_->executor(); }
  void close() { connection_->close(); }

  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    const auto slot = asio::get_associated_cancellation_slot(handler);
    asio::mutable_buffer into;
    for (auto next = asio::buffer_sequence_begin(buffers);
         into.size() == 0 && next != asio::buffer_sequence_end(buffers); ++next)
      into = *next;
    start(read_some(into), slot, std::forward<Handler>(handler));
  }
  /// Writes all of it: a frame goes out in one piece.
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    const auto slot = asio::get_associated_cancellation_slot(handler);
    std::string bytes(asio::buffer_size(buffers), '\0');
    asio::buffer_copy(asio::buffer(bytes), buffers);
    start(write(std::move(bytes)), slot, std::forward<Handler>(handler));
  }
  template <typename Handler>
  friend void async_teardown(boost::beast::role_type, Carrier& carrier, Handler&& handler) {
    const auto slot = asio::get_associated_cancellation_slot(handler);
    auto done = [handler = std::forward<Handler>(handler)](error_code, std::size_t) mutable {
      handler(error_code{});
    };
    carrier.start(carrier.end(), slot, std::move(done));
  }
  friend void beast_close_socket(Carrier& carrier) { carrier.close(); }

 private:
  /// @param size  0: the client is gone
  using Done = std::move_only_function<void(error_code, std::size_t size)>;

  void start(awaitable<std::size_t> operation, asio::cancellation_slot slot, Done done) {
    auto ended = [done = std::move(done)](std::exception_ptr, std::size_t size) mutable {
      done(size > 0 ? error_code{} : asio::error::eof, size);
    };
    asio::co_spawn(get_executor(), std::move(operation),
                   asio::bind_cancellation_slot(slot, std::move(ended)));
  }

  awaitable<std::size_t> read_some(asio::mutable_buffer into) {
    std::size_t size = asio::buffer_copy(into, asio::buffer(come_));
    come_.erase(0, size);
    if (size == 0) size = co_await connection_->read_some(into);
    co_return size;
  }
  awaitable<std::size_t> write(std::string bytes) {
    const bool written = co_await connection_->write(asio::buffer(bytes));
    co_return written ? bytes.size() : 0;
  }
  /// Until the client has ended it too.
  awaitable<std::size_t> end() {
    co_await connection_->end_writing();
    std::array<char, 512> rest;
    std::size_t size = 1;
    while (size > 0) size = co_await connection_->read_some(asio::buffer(rest));
    co_return size;
  }

  std::shared_ptr<Connection> connection_;
  std::string come_;  ///< and was not read yet
};

class WebSocketConnection final : public Connection {
 public:
  WebSocketConnection(Carrier carrier, HttpRequest upgrade, std::optional<control::Certificate> shown)
      : socket_{std::make_shared<Socket>(std::move(carrier))},
        upgrade_{std::move(upgrade)},
        shown_{std::move(shown)} {}
  ~WebSocketConnection() override { close(); }

  asio::any_io_executor executor() override { return socket_->stream.get_executor(); }

  awaitable<std::expected<std::optional<control::Certificate>, std::string>> open() override {
    const auto [error] = co_await socket_->stream.async_accept(upgrade_, kAwaited);
    if (error) co_return std::unexpected(error.message());
    socket_->stream.text(true);
    net::spawn(executor(), pump(socket_));
    co_return shown_;
  }

  awaitable<std::size_t> read_some(asio::mutable_buffer buffer) override {
    Socket& socket = *socket_;
    while (socket.inbox.empty() && !socket.ended) co_await socket.filled.wait();
    const std::size_t size = asio::buffer_copy(buffer, asio::buffer(socket.inbox));
    socket.inbox.erase(0, size);
    socket.taken.notify();
    co_return size;
  }

  awaitable<bool> write(asio::const_buffer bytes) override {
    std::string_view lines{static_cast<const char*>(bytes.data()), bytes.size()};
    while (!lines.empty()) {
      const std::string_view line = lines.substr(0, lines.find('\n'));
      const auto [error, size] = co_await socket_->stream.async_write(asio::buffer(line), kAwaited);
      if (error) co_return false;
      lines.remove_prefix(std::min(lines.size(), line.size() + 1));
    }
    co_return true;
  }

  awaitable<void> end_writing() override {
    const auto [gone] = co_await socket_->stream.async_close(socket_->farewell, kAwaited);
    static_cast<void>(gone);
  }
  void end_reading() override { socket_->end(); }
  void close() override {
    socket_->stream.next_layer().close();
    socket_->end();
  }

 private:
  struct Socket {
    explicit Socket(Carrier carrier) : stream{std::move(carrier)} {
      // The session has its own limits of time.
      stream.set_option(
          websocket::stream_base::timeout{std::chrono::seconds{5}, websocket::stream_base::none(), false});
      stream.auto_fragment(false);
    }
    void end() {
      ended = true;
      filled.notify();
      taken.notify();
    }

    websocket::stream<Carrier, false> stream;
    std::string inbox{};  ///< came, and was not read yet
    Signal filled, taken;
    websocket::close_reason farewell{websocket::close_code::normal};
    bool ended = false;
  };

  /// Reads a piece at a time, also while the inbox is not read, because reading answers pings; but no
  /// more ahead than a line may be long. A read of its own, since one that is cancelled takes the WebSocket
  /// with it, and then no reason could be written.
  static awaitable<void> pump(std::shared_ptr<Socket> socket) {
    std::array<char, 4096> piece;
    while (!socket->ended) {
      const auto [error, size] = co_await socket->stream.async_read_some(asio::buffer(piece), kAwaited);
      if (error) break;
      if (!socket->stream.got_text()) {
        socket->farewell = {websocket::close_code::unknown_data, "messages are text here, not binary"};
        break;
      }
      // A message is one line, however its JSON is laid out.
      const auto ends_line = [](char byte) { return byte == '\n' || byte == '\r'; };
      std::replace_if(piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(size), ends_line, ' ');
      socket->inbox.append(piece.data(), size);
      if (socket->stream.is_message_done()) socket->inbox += '\n';
      socket->filled.notify();
      while (socket->inbox.size() > control::kMaxLine && !socket->ended) co_await socket->taken.wait();
    }
    socket->end();
  }

  std::shared_ptr<Socket> socket_;
  HttpRequest upgrade_;
  std::optional<control::Certificate> shown_;
};

}  // namespace

std::unique_ptr<Connection> web_socket(std::shared_ptr<Connection> under, std::string come,
                                       HttpRequest upgrade, std::optional<control::Certificate> shown) {
  return std::make_unique<WebSocketConnection>(Carrier{std::move(under), std::move(come)}, std::move(upgrade),
                                               std::move(shown));
}

}  // namespace truepose::daemon
