#include "tools/proxy/tcp_route.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <list>
#include <sstream>

#include "tools/steering/accept_clients.hpp"

namespace truepose::proxy {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr auto kToResult = asio::as_tuple(asio::use_awaitable);
constexpr double kSlices_per_s = 20;  // in which a slow line delivers

std::string text(const tcp::endpoint& endpoint) { return (std::ostringstream{} << endpoint).str(); }

/// A reset, not an orderly end.
void reset(tcp::socket& socket) {
  error_code ignored;
  socket.set_option(asio::socket_base::linger{true, 0}, ignored);
  socket.close(ignored);
}

asio::awaitable<void> wait(asio::any_io_executor executor, std::chrono::microseconds time) {
  if (time.count() == 0) co_return;
  asio::steady_timer timer{executor, time};
  co_await timer.async_wait(kToResult);
}

/// A client's connection and ours to the target.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket client, const tcp::endpoint& target, const std::shared_ptr<Ways>& ways)
      : client_{std::move(client)},
        server_{client_.get_executor()},
        target_{target},
        lifted_{client_.get_executor(), asio::steady_timer::time_point::max()},
        ways_{ways} {}

  asio::awaitable<void> run() {
    const auto self = shared_from_this();
    auto [refused] = co_await server_.async_connect(target_, kToResult);
    if (refused) {
      cut();
      co_return;
    }
    error_code ignored;
    client_.set_option(tcp::no_delay{true}, ignored);
    server_.set_option(tcp::no_delay{true}, ignored);
    asio::co_spawn(
        client_.get_executor(),
        [self] { return self->pump(self->client_, self->server_, self->ways_->to_target); }, asio::detached);
    co_await pump(server_, client_, ways_->to_client);
  }

  void cut() {
    reset(client_);
    reset(server_);
    lifted_.cancel();
  }
  /// The faults have changed.
  void wake() { lifted_.cancel(); }
  bool open() const { return client_.is_open(); }

 private:
  /// Until either end closes; then the other end is closed too.
  asio::awaitable<void> pump(tcp::socket& from, tcp::socket& to, FaultyWay& way) {
    const auto self = shared_from_this();
    std::array<char, 64 * 1024> buffer;
    for (;;) {
      auto [ended, size] = co_await from.async_read_some(asio::buffer(buffer), kToResult);
      while (way.faults.half_open && from.is_open()) co_await lifted_.async_wait(kToResult);
      if (ended == asio::error::eof) {
        error_code ignored;
        to.shutdown(tcp::socket::shutdown_send, ignored);
        co_return;
      }
      if (ended) {
        cut();
        co_return;
      }
      if (way.faults.coalesce_ms > 0) {
        co_await wait(from.get_executor(), joining_time(way.faults));
        size += pending(from, asio::buffer(buffer) + size);
      }
      FaultyWay::Outgoing piece = way.piece({buffer.data(), size});
      co_await wait(from.get_executor(), piece.delay);
      const bool written = co_await write(to, piece.bytes, way);
      if (!written) {
        cut();
        co_return;
      }
    }
  }

  static std::chrono::microseconds joining_time(const Faults& faults) {
    return std::chrono::microseconds{static_cast<std::int64_t>(faults.coalesce_ms * 1000)};
  }

  /// What has come in meanwhile.
  static std::size_t pending(tcp::socket& from, asio::mutable_buffer room) {
    error_code none;
    if (room.size() == 0 || from.available(none) == 0) return 0;
    return from.read_some(room, none);
  }

  static asio::awaitable<bool> write(tcp::socket& to, const std::string& bytes, const FaultyWay& way) {
    for (std::size_t sent = 0; sent < bytes.size();) {
      const double rate = way.faults.bytes_per_s;
      const std::size_t slice = std::min(
          bytes.size() - sent,
          rate > 0 ? std::max<std::size_t>(1, static_cast<std::size_t>(rate / kSlices_per_s)) : bytes.size());
      auto [lost, size] = co_await asio::async_write(to, asio::buffer(bytes.data() + sent, slice), kToResult);
      if (lost) co_return false;
      sent += size;
      if (rate > 0) {
        const std::chrono::duration<double> time{static_cast<double>(size) / rate};
        co_await wait(to.get_executor(), std::chrono::ceil<std::chrono::microseconds>(time));
      }
    }
    co_return true;
  }

  tcp::socket client_, server_;
  tcp::endpoint target_;
  asio::steady_timer lifted_;
  std::shared_ptr<Ways> ways_;
};

class TcpRoute : public Route {
 public:
  TcpRoute(const asio::any_io_executor& executor, const tcp::endpoint& listen, const tcp::endpoint& target,
           Random& seeds)
      : ways_{std::make_shared<Ways>(seeds)},
        acceptor_{std::make_shared<tcp::acceptor>(executor, listen)},
        target_{target} {
    steering::accept_clients(acceptor_, text(listen),
                             [this](tcp::socket socket) { welcome(std::move(socket)); });
  }
  ~TcpRoute() override {
    acceptor_->close();
    cut();
  }

  std::string listens() const override { return text(acceptor_->local_endpoint()); }

  void apply(const Command& command) override {
    ways_->apply(command);
    if (command.cut) cut();
    for (const auto& connection : open_ones()) connection->wake();
  }

  RouteStatistics statistics() const override {
    return {.protocol = "tcp",
            .listen = listens(),
            .target = text(target_),
            .connections = accepted_,
            .open = open_ones().size(),
            .cut = cut_,
            .to_target = ways_->to_target.counters(),
            .to_client = ways_->to_client.counters()};
  }

 private:
  void welcome(tcp::socket socket) {
    ++accepted_;
    const auto connection = std::make_shared<Connection>(std::move(socket), target_, ways_);
    connections_.remove_if([](const auto& known) { return known.expired(); });
    connections_.push_back(connection);
    asio::co_spawn(
        acceptor_->get_executor(), [connection] { return connection->run(); }, asio::detached);
  }

  std::vector<std::shared_ptr<Connection>> open_ones() const {
    std::vector<std::shared_ptr<Connection>> open;
    for (const auto& known : connections_) {
      if (auto connection = known.lock(); connection && connection->open())
        open.push_back(std::move(connection));
    }
    return open;
  }

  void cut() {
    for (const auto& connection : open_ones()) {
      connection->cut();
      ++cut_;
    }
  }

  std::shared_ptr<Ways> ways_;
  std::shared_ptr<tcp::acceptor> acceptor_;
  tcp::endpoint target_;
  std::list<std::weak_ptr<Connection>> connections_;
  std::uint64_t accepted_ = 0, cut_ = 0;
};

}  // namespace

std::unique_ptr<Route> tcp_route(const asio::any_io_executor& executor, const tcp::endpoint& listen,
                                 const tcp::endpoint& target, Random& seeds) {
  return std::make_unique<TcpRoute>(executor, listen, target, seeds);
}

}  // namespace truepose::proxy
