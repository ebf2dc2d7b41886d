#include "daemon/control/control_server.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "daemon/control/session.hpp"
#include "daemon/control/token_file.hpp"
#include "drivers/port_holder.hpp"
#include "proto/control/rfc3339.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using asio::ip::tcp;
using control::ErrorCode;

struct ControlServer::Impl {
  std::shared_ptr<SessionContext> context;
  tcp::acceptor acceptor;

  void admit(tcp::socket socket);
};

namespace {

std::expected<tcp::acceptor, std::string> listen(asio::any_io_executor executor,
                                                 const config::Endpoint& endpoint) {
  const std::string where = endpoint.host + ":" + std::to_string(endpoint.port);
  boost::system::error_code error;
  const asio::ip::address address =
      asio::ip::make_address(endpoint.host == "localhost" ? "127.0.0.1" : endpoint.host, error);
  if (error) return std::unexpected("control.listen: \"" + endpoint.host + "\" is not an IP address");
  if (!address.is_loopback())
    return std::unexpected("control.listen: " + where +
                           " can be reached from other machines, which needs TLS; listen on 127.0.0.1");
  const tcp::endpoint local{address, endpoint.port};
  tcp::acceptor acceptor{executor};
  acceptor.open(local.protocol(), error);
  // The port may still have connections of the daemon before us that are closing.
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address{true}, error);
  if (!error) acceptor.bind(local, error);
  if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
  if (error == asio::error::address_in_use)
    return std::unexpected("control.listen: " + where + " is in use by " +
                           drivers::port_holder(drivers::Protocol::Tcp, endpoint.port));
  if (error) return std::unexpected("control.listen: " + where + ": " + error.message());
  return acceptor;
}

}  // namespace

void ControlServer::Impl::admit(tcp::socket socket) {
  const std::size_t open = context->sessions.size();
  const std::size_t most = context->limits.connections;
  if (open >= 2 * most) return;  // those beyond `most` are only told why; even of these there is an end
  const auto session = std::make_shared<Session>(std::move(socket), context);
  if (open < most) return session->start();
  session->refuse({ErrorCode::Busy, "closed: " + std::to_string(most) + " connections are open already"});
}

std::expected<std::unique_ptr<ControlServer>, std::string> ControlServer::start(
    asio::any_io_executor executor, ControlServerParts parts, const config::ControlConfig& config,
    std::string cell_name, ControlLimits limits) {
  auto token = read_token(config.token_file);
  if (!token) return std::unexpected(token.error());
  auto acceptor = listen(executor, config.listen);
  if (!acceptor) return std::unexpected(acceptor.error());

  auto context = std::make_shared<SessionContext>(
      SessionContext{std::move(parts), limits, std::move(cell_name), std::move(*token), {}, {}, {}, {}, {}});
  for (std::string& method : context->parts.cell.methods()) context->cell_methods.insert(std::move(method));
  context->started = context->parts.clock.now();
  context->started_text = control::rfc3339(context->parts.wall_clock());
  auto impl = std::make_shared<Impl>(Impl{std::move(context), std::move(*acceptor)});

  const auto accept = [](std::shared_ptr<Impl> server) -> asio::awaitable<void> {
    while (server->acceptor.is_open()) {
      auto accepted = co_await server->acceptor.async_accept(asio::as_tuple(asio::use_awaitable));
      auto& [error, socket] = accepted;
      if (!server->acceptor.is_open()) co_return;
      if (!error) {
        server->admit(std::move(socket));
        continue;
      }
      // Out of file descriptors, mostly: trying again at once would only burn the processor.
      server->context->parts.warn("control: cannot accept a connection: " + error.message());
      const drivers::TimePoint later = server->context->parts.clock.now() + std::chrono::milliseconds{100};
      co_await server->context->parts.clock.sleep_until(later);
    }
  };
  asio::co_spawn(executor, accept(impl), [impl](std::exception_ptr) {});
  return std::unique_ptr<ControlServer>{new ControlServer{std::move(impl)}};
}

ControlServer::ControlServer(std::shared_ptr<Impl> impl) : impl_{std::move(impl)} {}

ControlServer::~ControlServer() { stop(); }

std::uint16_t ControlServer::port() const { return impl_->acceptor.local_endpoint().port(); }

std::vector<std::string> ControlServer::methods() const {
  std::set<std::string, std::less<>> all = Session::own_methods();
  all.insert(impl_->context->cell_methods.begin(), impl_->context->cell_methods.end());
  return {all.begin(), all.end()};
}

void ControlServer::stop() {
  boost::system::error_code ignored;
  impl_->acceptor.close(ignored);
  const std::set<Session*> sessions = impl_->context->sessions;
  for (Session* session : sessions) session->shared_from_this()->stop();
}

}  // namespace truepose::daemon
