#include "daemon/web/web_server.hpp"

#include <map>
#include <utility>

#include "daemon/control/acceptor.hpp"
#include "daemon/control/tls_identity.hpp"
#include "daemon/web/web_answers.hpp"
#include "daemon/web/web_socket.hpp"
#include "drivers/deadline.hpp"
#include "drivers/net/spawn.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using drivers::StartFailure;

struct WebServer::Impl : std::enable_shared_from_this<WebServer::Impl> {
  WebServerParts parts;
  WebLimits limits;
  bool tls;
  WebAnswers answers;
  std::shared_ptr<net::Listener> listener;
  /// Those that are no sessions, by their numbers, which rise.
  std::map<std::uint64_t, std::shared_ptr<Connection>> guests{};
  std::uint64_t last_number = 0;

  Impl(WebServerParts parts_of, const config::WebConfig& config, WebLimits limits_of, bool over_tls,
       std::shared_ptr<net::Listener> listening)
      : parts{std::move(parts_of)},
        limits{limits_of},
        tls{over_tls},
        answers{parts, config.origins, over_tls},
        listener{std::move(listening)} {}

  void admit(std::unique_ptr<net::Stream> stream);
  void close_oldest();
  asio::awaitable<void> converse(std::shared_ptr<Connection> connection, Peer peer);
  asio::awaitable<bool> write(Connection& connection, std::string bytes);
};

void WebServer::Impl::admit(std::unique_ptr<net::Stream> stream) {
  Peer peer = Peer::of(*stream);
  if (guests.size() >= limits.connections) close_oldest();
  const std::uint64_t number = ++last_number;
  std::shared_ptr<Connection>& guest = guests[number];
  if (tls) {
    guest = tls_connection(std::move(stream), parts.control.tls_identity()->context());
  } else {
    guest = plain_connection(std::move(stream));
  }
  const auto ended = [self = shared_from_this(), number](std::exception_ptr) { self->guests.erase(number); };
  net::spawn(listener->executor(), converse(guest, std::move(peer)), ended);
}

void WebServer::Impl::close_oldest() {
  const auto oldest = guests.begin();
  oldest->second->close();
  guests.erase(oldest);
}

asio::awaitable<void> WebServer::Impl::converse(std::shared_ptr<Connection> connection, Peer peer) {
  drivers::TimePoint until = parts.clock.now() + limits.handshake;
  const auto opened = co_await drivers::before(parts.clock, until, connection->open());
  bool goes_on = opened && *opened;
  HttpReader reader;
  while (goes_on) {
    auto request = co_await drivers::before(parts.clock, until, reader.next(*connection));
    if (!request) break;
    if (!*request) {
      if (const auto& complaint = request->error())
        co_await write(*connection, bytes_of(*complaint, false, true));
      break;
    }
    if (answers.is_upgrade(**request)) {
      parts.control.admit(web_socket(connection, reader.rest(), std::move(**request), **opened),
                          std::move(peer));
      co_return;
    }
    const bool keep_alive = (*request)->keep_alive();
    const bool has_body = (*request)->method() != boost::beast::http::verb::head;
    const HttpAnswer answer = co_await answers.answer(std::move(**request), peer, **opened);
    const bool written = co_await write(*connection, bytes_of(answer, keep_alive, has_body));
    goes_on = written && keep_alive;
    until = parts.clock.now() + limits.idle;
  }
  connection->close();
}

asio::awaitable<bool> WebServer::Impl::write(Connection& connection, std::string bytes) {
  const drivers::TimePoint stalled = parts.clock.now() + limits.write_stall;
  const auto written = co_await drivers::before(parts.clock, stalled, connection.write(asio::buffer(bytes)));
  co_return written.value_or(false);
}

std::expected<WebAddress, std::string> web_address(const config::Endpoint& listen, bool has_tls) {
  boost::system::error_code error;
  const auto address = asio::ip::make_address(listen.host == "localhost" ? "127.0.0.1" : listen.host, error);
  if (error)
    return std::unexpected("web.listen: \"" + listen.host +
                           "\" is not an IP address: give 127.0.0.1, or one of this machine");
  if (address.is_loopback()) return WebAddress{address, false};
  if (has_tls) return WebAddress{address, true};
  return std::unexpected("web.listen: " + listen.host +
                         " can be reached from other machines, which needs TLS: give certificate and key in "
                         "control.tls, or listen on 127.0.0.1");
}

std::expected<std::unique_ptr<WebServer>, StartFailure> WebServer::start(asio::any_io_executor executor,
                                                                         WebServerParts parts,
                                                                         const config::WebConfig& config,
                                                                         WebLimits limits) {
  const auto address = web_address(*config.listen, parts.control.tls_identity() != nullptr);
  if (!address) return std::unexpected(StartFailure{address.error()});
  auto listener = listen(parts.network, executor, "web.listen", *config.listen, address->address);
  if (!listener) return std::unexpected(listener.error());
  const auto impl =
      std::make_shared<Impl>(std::move(parts), config, limits, address->tls, *std::move(listener));
  return std::unique_ptr<WebServer>{new WebServer{impl}};
}

void WebServer::serve() {
  const auto admit = [server = impl_.get()](std::unique_ptr<net::Stream> stream) {
    server->admit(std::move(stream));
  };
  accept_who_stays({impl_, impl_->listener.get()}, impl_->parts.warn, "web", admit);
}

WebServer::WebServer(std::shared_ptr<Impl> impl) : impl_{std::move(impl)} {}

WebServer::~WebServer() { stop(); }

std::uint16_t WebServer::port() const { return impl_->listener->local().port; }

std::size_t WebServer::connections() const { return impl_->guests.size(); }

void WebServer::stop() {
  impl_->listener->close();
  while (!impl_->guests.empty()) impl_->close_oldest();
}

}  // namespace truepose::daemon
