#include "drivers/net/listener.hpp"

#include <sys/socket.h>
#include <sys/stat.h>

#include <boost/asio/basic_socket_acceptor.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <utility>

#include "drivers/net/socket_stream.hpp"
#include "drivers/net/spawn.hpp"

namespace truepose::net {

namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using Protocol = asio::generic::stream_protocol;
using Acceptor = asio::basic_socket_acceptor<Protocol>;
using ReusePort = asio::detail::socket_option::boolean<SOL_SOCKET, SO_REUSEPORT>;

class SocketListener final : public Listener {
 public:
  explicit SocketListener(Acceptor acceptor) : acceptor_{std::move(acceptor)} {}

  asio::any_io_executor executor() override { return acceptor_.get_executor(); }
  asio::awaitable<Result<std::unique_ptr<Stream>>> accept() override {
    auto [error, socket] = co_await acceptor_.async_accept(kAsTuple);
    if (error) co_return std::unexpected(error);
    co_return std::make_unique<SocketStream>(std::move(socket));
  }
  void close() noexcept override {
    error_code ignored;
    acceptor_.close(ignored);
  }
  bool is_open() const override { return acceptor_.is_open(); }
  Stream::End local() const override {
    error_code unknown;
    return end_of(acceptor_.local_endpoint(unknown));
  }

 private:
  Acceptor acceptor_;
};

class BoundPort final : public HeldPort {
 public:
  explicit BoundPort(Acceptor acceptor) : acceptor_{std::move(acceptor)} {}

  std::uint16_t port() const override {
    error_code unknown;
    return end_of(acceptor_.local_endpoint(unknown)).port;
  }

 private:
  Acceptor acceptor_;
};

Acceptor bound(const asio::any_io_executor& executor, const std::string& address, std::uint16_t port,
               ListenOptions options, error_code& error) {
  const asio::ip::tcp::endpoint endpoint{asio::ip::make_address(address, error), port};
  Acceptor acceptor{executor};
  if (!error) acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(Acceptor::reuse_address{true}, error);
  if (!error && options.shares_port) acceptor.set_option(ReusePort{true}, error);
  if (!error) acceptor.bind(endpoint, error);
  return acceptor;
}

Result<std::shared_ptr<Listener>> listening(Acceptor acceptor, error_code error) {
  if (!error) acceptor.listen(Acceptor::max_listen_connections, error);
  if (error) return std::unexpected(error);
  return std::make_shared<SocketListener>(std::move(acceptor));
}

asio::awaitable<void> accept_each(std::shared_ptr<Listener> listener,
                                  std::function<void(std::unique_ptr<Stream>)> admit, Warn warn) {
  while (listener->is_open()) {
    auto come = co_await listener->accept();
    if (!listener->is_open()) co_return;
    if (come) {
      admit(*std::move(come));
      continue;
    }
    // Out of file descriptors, mostly: trying again at once would only burn the processor.
    warn("cannot accept a connection: " + come.error().message());
    asio::steady_timer later{listener->executor(), std::chrono::milliseconds{100}};
    co_await later.async_wait(asio::use_awaitable);
  }
}

}  // namespace

Result<std::shared_ptr<Listener>> listen_tcp(const asio::any_io_executor& executor,
                                             const std::string& address, std::uint16_t port,
                                             ListenOptions options) {
  error_code error;
  Acceptor acceptor = bound(executor, address, port, options, error);
  return listening(std::move(acceptor), error);
}

Result<std::unique_ptr<HeldPort>> hold_tcp(const asio::any_io_executor& executor, const std::string& address,
                                           std::uint16_t port) {
  // Whether another program listens there, binding a shared port does not show.
  if (const auto is_free = listen_tcp(executor, address, port); !is_free)
    return std::unexpected(is_free.error());
  error_code error;
  Acceptor acceptor = bound(executor, address, port, {.shares_port = true}, error);
  if (error) return std::unexpected(error);
  return std::make_unique<BoundPort>(std::move(acceptor));
}

Result<std::shared_ptr<Listener>> listen_local(const asio::any_io_executor& executor,
                                               const std::filesystem::path& path, unsigned mode) {
  error_code error;
  Acceptor acceptor{executor};
  acceptor.open(asio::local::stream_protocol{}, error);
  if (!error) acceptor.bind(asio::local::stream_protocol::endpoint{path.string()}, error);
  // No client can connect before it listens, which is after its mode is set.
  if (!error && ::chmod(path.c_str(), mode) != 0) error = {errno, boost::system::system_category()};
  return listening(std::move(acceptor), error);
}

void accept_all(std::shared_ptr<Listener> listener, std::function<void(std::unique_ptr<Stream>)> admit,
                Warn warn) {
  const auto executor = listener->executor();
  spawn(executor, accept_each(std::move(listener), std::move(admit), std::move(warn)));
}

}  // namespace truepose::net
