#include "tools/proxy/tcp_route.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <list>

#include "drivers/net/spawn.hpp"
#include "proto/text/host_port.hpp"
#include "tools/steering/accept_clients.hpp"

namespace truepose::proxy {

namespace asio = boost::asio;

namespace {

constexpr auto kToResult = asio::as_tuple(asio::use_awaitable);
constexpr double kSlices_per_s = 20;  // in which a slow line delivers

std::string text(const net::Stream::End& end) { return text::host_port(end.host, end.port); }

asio::awaitable<void> wait(asio::any_io_executor executor, std::chrono::microseconds time) {
  if (time.count() == 0) co_return;
  asio::steady_timer timer{executor, time};
  co_await timer.async_wait(kToResult);
}

/// A client's connection and ours to the target.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(std::unique_ptr<net::Stream> client, net::Stream::End target, const std::shared_ptr<Ways>& ways)
      : client_{std::move(client)},
        server_{net::tcp_stream(client_->executor())},
        target_{std::move(target)},
        lifted_{client_->executor(), asio::steady_timer::time_point::max()},
        ways_{ways} {}

  static asio::awaitable<void> run(std::shared_ptr<Connection> self) {
    const auto refused = co_await self->server_->connect(self->target_.host, self->target_.port);
    if (refused) co_return self->cut();
    net::send_at_once(*self->client_);
    net::spawn(self->client_->executor(), pump(self, *self->client_, *self->server_, self->ways_->to_target));
    co_await pump(self, *self->server_, *self->client_, self->ways_->to_client);
  }

  void cut() {
    net::reset(*client_);
    net::reset(*server_);
    lifted_.cancel();
  }
  /// The faults have changed.
  void wake() { lifted_.cancel(); }
  bool open() const { return client_->is_open(); }

 private:
  /// Until either end closes; then the other end is closed too.
  static asio::awaitable<void> pump(std::shared_ptr<Connection> self, net::Stream& from, net::Stream& to,
                                    FaultyWay& way) {
    std::vector<char> buffer(64 * 1024);
    for (;;) {
      const auto [ended, size] = co_await from.read(buffer);
      while (way.faults.half_open && from.is_open()) co_await self->lifted_.async_wait(kToResult);
      if (ended == asio::error::eof) {
        co_await to.end_writing();
        co_return;
      }
      if (ended) co_return self->cut();
      std::size_t come = size;
      if (way.faults.coalesce_ms > 0) {
        co_await wait(from.executor(), joining_time(way.faults));
        come += net::read_waiting(from, std::span{buffer}.subspan(size));
      }
      FaultyWay::Outgoing piece = way.piece({buffer.data(), come});
      co_await wait(from.executor(), piece.delay);
      const bool written = co_await write(to, piece.bytes, way);
      if (!written) co_return self->cut();
    }
  }

  static std::chrono::microseconds joining_time(const Faults& faults) {
    return std::chrono::microseconds{static_cast<std::int64_t>(faults.coalesce_ms * 1000)};
  }

  static asio::awaitable<bool> write(net::Stream& to, const std::string& bytes, const FaultyWay& way) {
    for (std::size_t sent = 0; sent < bytes.size();) {
      const double rate = way.faults.bytes_per_s;
      const std::size_t slice = std::min(
          bytes.size() - sent,
          rate > 0 ? std::max<std::size_t>(1, static_cast<std::size_t>(rate / kSlices_per_s)) : bytes.size());
      const auto lost = co_await to.write(std::string_view{bytes}.substr(sent, slice));
      if (lost) co_return false;
      sent += slice;
      if (rate > 0) {
        const std::chrono::duration<double> time{static_cast<double>(slice) / rate};
        co_await wait(to.executor(), std::chrono::ceil<std::chrono::microseconds>(time));
      }
    }
    co_return true;
  }

  std::unique_ptr<net::Stream> client_, server_;
  net::Stream::End target_;
  asio::steady_timer lifted_;
  std::shared_ptr<Ways> ways_;
};

class TcpRoute : public Route {
 public:
  TcpRoute(const asio::any_io_executor& executor, const net::Stream::End& listen, net::Stream::End target,
           Random& seeds)
      : ways_{std::make_shared<Ways>(seeds)},
        listener_{steering::listen_or_throw(executor, listen.host, listen.port)},
        target_{std::move(target)} {
    const auto admit = [this](std::unique_ptr<net::Stream> stream) { welcome(std::move(stream)); };
    steering::accept_clients(listener_, text(listen), admit);
  }
  ~TcpRoute() override {
    listener_->close();
    cut();
  }

  std::string listens() const override { return text(listener_->local()); }

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
  void welcome(std::unique_ptr<net::Stream> stream) {
    ++accepted_;
    const auto connection = std::make_shared<Connection>(std::move(stream), target_, ways_);
    connections_.remove_if([](const auto& known) { return known.expired(); });
    connections_.push_back(connection);
    net::spawn(listener_->executor(), Connection::run(connection));
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
  std::shared_ptr<net::Listener> listener_;
  net::Stream::End target_;
  std::list<std::weak_ptr<Connection>> connections_;
  std::uint64_t accepted_ = 0, cut_ = 0;
};

}  // namespace

std::unique_ptr<Route> tcp_route(const asio::any_io_executor& executor, const net::Stream::End& listen,
                                 const net::Stream::End& target, Random& seeds) {
  return std::make_unique<TcpRoute>(executor, listen, target, seeds);
}

}  // namespace truepose::proxy
