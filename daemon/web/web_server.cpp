#include "daemon/web/web_server.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <map>
#include <utility>

#include "daemon/control/acceptor.hpp"
#include "daemon/control/tls_identity.hpp"
#include "daemon/web/web_pages.hpp"
#include "daemon/web/web_socket.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;
using drivers::StartFailure;

namespace {

using namespace asio::experimental::awaitable_operators;
using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;
using PlainStream = tcp::socket;
using TlsStream = asio::ssl::stream<tcp::socket>;
using Identity = std::shared_ptr<asio::ssl::context>;  ///< that outlives what is made by it; null: no TLS

constexpr auto kAwaited = asio::as_tuple(asio::use_awaitable);
constexpr std::size_t kMostHeaderBytes = 8 * 1024;
constexpr const char* kHtmlType = "text/html; charset=utf-8";
constexpr const char* kJsonType = "application/json";
constexpr const char* kPlainType = "text/plain; charset=utf-8";
constexpr const char* kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }
std::string_view field(const Request& request, http::field name) { return view(request[name]); }

Response answer_with(http::status status, const char* type, std::string body) {
  Response response{status, 11};
  response.set(http::field::content_type, type);
  response.set(http::field::cache_control, "no-store");
  response.set("X-Content-Type-Options", "nosniff");
  // The page has its script and style in itself, and talks to the server that it is from.
  response.set(
      "Content-Security-Policy",
      "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self'; img-src data:; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  response.body() = std::move(body);
  response.prepare_payload();
  return response;
}

Response refusal(http::status status, const std::string& why) {
  return answer_with(status, kPlainType, why + "\n");
}

/// A connection that is no session yet, and how it is closed.
struct Guest {
  Peer peer;
  std::function<void()> close;
};

}  // namespace

struct WebServer::Impl : std::enable_shared_from_this<WebServer::Impl> {
  WebServerParts parts;
  config::WebConfig config;
  WebLimits limits;
  bool tls;
  tcp::acceptor acceptor;
  std::map<std::uint64_t, Guest> guests{};  ///< by their numbers, which rise
  std::uint64_t last_number = 0;

  Impl(WebServerParts parts_of, config::WebConfig config_of, WebLimits limits_of, bool over_tls,
       tcp::acceptor listening)
      : parts{std::move(parts_of)},
        config{std::move(config_of)},
        limits{limits_of},
        tls{over_tls},
        acceptor{std::move(listening)} {}

  void admit(tcp::socket socket);
  void close_oldest();
  template <typename Stream>
  void serve(std::shared_ptr<Stream> stream, Peer peer, Identity identity);
  template <typename Stream>
  asio::awaitable<void> converse(std::shared_ptr<Stream> stream, Peer peer, Identity identity);
  template <typename Stream>
  asio::awaitable<bool> write(Stream& stream, Response response);

  /// Why a request is none that this server takes; empty: it is.
  std::string fault_of(const Request& request) const;
  std::string own_origin(const Request& request) const;
  bool is_upgrade(const Request& request) const;
  asio::awaitable<Response> answer(Request request, Peer peer, std::optional<control::Certificate> shown);
  asio::awaitable<Response> answer_to_known(Request request, Peer peer,
                                            std::optional<control::Certificate> shown);
  asio::awaitable<std::string> why_unknown(Request request, Peer peer,
                                           std::optional<control::Certificate> shown);
};

namespace {

template <typename Stream>
asio::awaitable<bool> shake_hands(Stream& stream) {
  if constexpr (std::is_same_v<Stream, TlsStream>) {
    const auto [error] = co_await stream.async_handshake(asio::ssl::stream_base::server, kAwaited);
    co_return !error;
  }
  co_return true;
}

template <typename Stream>
std::optional<control::Certificate> shown_by(Stream& stream) {
  if constexpr (std::is_same_v<Stream, TlsStream>) {
    const X509* const shown = SSL_get0_peer_certificate(stream.native_handle());
    if (shown) return control::facts_of(*shown);
  }
  return std::nullopt;
}

template <typename Stream>
void shut_down(Stream& stream) {
  boost::system::error_code gone;
  beast::get_lowest_layer(stream).shutdown(tcp::socket::shutdown_both, gone);
  beast::get_lowest_layer(stream).close(gone);
}

using Parser = http::request_parser<http::empty_body>;

template <typename Stream>
asio::awaitable<boost::system::error_code> read_request(Stream& stream, beast::flat_buffer& buffer,
                                                        Parser& parser) {
  const auto [error, size] = co_await http::async_read(stream, buffer, parser, kAwaited);
  co_return error;
}

/// What is answered to something that is no request; none: nobody is there any more.
std::optional<Response> complaint(boost::system::error_code error) {
  if (error == http::error::header_limit)
    return refusal(http::status::request_header_fields_too_large, "the header is too long");
  if (error == http::error::unexpected_body || error == http::error::body_limit)
    return refusal(http::status::payload_too_large, "no request here has a body");
  if (error.category() == http::make_error_code(http::error::bad_method).category() &&
      error != http::error::end_of_stream && error != http::error::partial_message)
    return refusal(http::status::bad_request, "this is no HTTP request: " + error.message());
  return std::nullopt;
}

}  // namespace

void WebServer::Impl::admit(tcp::socket socket) {
  Peer peer = Peer::of(socket);
  if (guests.size() >= limits.connections) close_oldest();
  if (!tls) return serve(std::make_shared<PlainStream>(std::move(socket)), std::move(peer), nullptr);
  Identity identity = parts.control.tls_identity()->context();
  auto stream = std::make_shared<TlsStream>(std::move(socket), *identity);
  serve(std::move(stream), std::move(peer), std::move(identity));
}

void WebServer::Impl::close_oldest() {
  const Guest oldest = guests.begin()->second;  // which leaves the list as it is closed
  oldest.close();
}

template <typename Stream>
void WebServer::Impl::serve(std::shared_ptr<Stream> stream, Peer peer, Identity identity) {
  const std::uint64_t number = ++last_number;
  guests[number] = {peer, [self = this, number, stream] {
                      shut_down(*stream);
                      self->guests.erase(number);
                    }};
  const auto ended = [self = shared_from_this(), number](std::exception_ptr) { self->guests.erase(number); };
  asio::co_spawn(acceptor.get_executor(), converse(std::move(stream), std::move(peer), std::move(identity)),
                 ended);
}

template <typename Stream>
asio::awaitable<void> WebServer::Impl::converse(std::shared_ptr<Stream> stream, Peer peer,
                                                Identity identity) {
  drivers::TimePoint until = parts.clock.now() + limits.handshake;
  auto no_handshake = parts.clock.sleep_until(until);
  const auto handshake = co_await (shake_hands(*stream) || std::move(no_handshake));
  if (handshake.index() == 1 || !std::get<0>(handshake)) co_return shut_down(*stream);
  const std::optional<control::Certificate> shown = shown_by(*stream);

  beast::flat_buffer buffer;
  for (bool goes_on = true; goes_on;) {
    Parser parser;
    parser.header_limit(kMostHeaderBytes);
    parser.body_limit(std::uint64_t{0});
    auto too_late = parts.clock.sleep_until(until);
    const auto outcome = co_await (read_request(*stream, buffer, parser) || std::move(too_late));
    if (outcome.index() == 1) break;
    if (const auto error = std::get<0>(outcome)) {
      auto last = complaint(error);
      if (!last) break;
      last->keep_alive(false);
      const bool said = co_await write(*stream, *std::move(last));
      static_cast<void>(said);
      break;
    }
    Request request = parser.release();
    if (is_upgrade(request)) {
      auto connection = std::make_unique<WebSocketConnection<Stream>>(std::move(*stream), std::move(request),
                                                                      shown, identity);
      parts.control.admit(std::move(connection), std::move(peer));
      co_return;
    }
    const bool keep_alive = request.keep_alive();
    const bool is_head = request.method() == http::verb::head;
    Response response = co_await answer(std::move(request), peer, shown);
    response.keep_alive(keep_alive);
    if (is_head) response.body().clear();  // whose length is told all the same
    const bool written = co_await write(*stream, std::move(response));
    goes_on = written && keep_alive;
    until = parts.clock.now() + limits.idle;
  }
  shut_down(*stream);
}

template <typename Stream>
asio::awaitable<bool> WebServer::Impl::write(Stream& stream, Response response) {
  const auto send = [](Stream& to, Response& what) -> asio::awaitable<bool> {
    const auto [error, size] = co_await http::async_write(to, what, kAwaited);
    co_return !error;
  };
  auto stalled = parts.clock.sleep_until(parts.clock.now() + limits.write_stall);
  const auto outcome = co_await (send(stream, response) || std::move(stalled));
  co_return outcome.index() == 0 && std::get<0>(outcome);
}

// What is asked for.

std::string WebServer::Impl::own_origin(const Request& request) const {
  return (tls ? "https://" : "http://") + std::string{field(request, http::field::host)};
}

std::string WebServer::Impl::fault_of(const Request& request) const {
  // Over TLS it is the certificate by which a browser knows whose server it talks to.
  if (!tls && !is_loopback_name(field(request, http::field::host)))
    return "ask for 127.0.0.1 or localhost: this server is this machine's own";
  if (view(request.target()) != "/rpc") return {};
  if (origin_may(field(request, http::field::origin), own_origin(request), config.origins)) return {};
  return "pages of " + std::string{field(request, http::field::origin).substr(0, 200)} +
         " may not speak the control protocol; list the origin in the cell file's web.origins";
}

bool WebServer::Impl::is_upgrade(const Request& request) const {
  return beast::websocket::is_upgrade(request) && view(request.target()) == "/rpc" &&
         fault_of(request).empty();
}

asio::awaitable<Response> WebServer::Impl::answer(Request request, Peer peer,
                                                  std::optional<control::Certificate> shown) {
  if (std::string fault = fault_of(request); !fault.empty())
    co_return refusal(http::status::forbidden, fault);
  if (request.method() != http::verb::head && request.method() != http::verb::get) {
    Response response = refusal(http::status::method_not_allowed, "only GET and HEAD are served here");
    response.set(http::field::allow, "GET, HEAD");
    co_return response;
  }
  const std::string_view target = view(request.target()).substr(0, view(request.target()).find('?'));
  Response response = refusal(http::status::not_found, "served are /, /metrics, /healthz and /rpc");
  if (target == "/") {
    response = answer_with(http::status::ok, kHtmlType, std::string{dashboard_page()});
  } else if (target == "/rpc") {
    response = refusal(http::status::upgrade_required, "the control protocol is spoken over WebSocket here");
    response.set(http::field::upgrade, "websocket");
  } else if (target == "/metrics" || target == "/healthz") {
    response = co_await answer_to_known(std::move(request), std::move(peer), std::move(shown));
  }
  co_return response;
}

asio::awaitable<Response> WebServer::Impl::answer_to_known(Request request, Peer peer,
                                                           std::optional<control::Certificate> shown) {
  const bool is_metrics = view(request.target()).starts_with("/metrics");
  const std::string unknown = co_await why_unknown(std::move(request), std::move(peer), std::move(shown));
  if (!unknown.empty()) {
    Response response = refusal(http::status::unauthorized, unknown);
    response.set(http::field::www_authenticate, "Bearer realm=\"truepose\"");
    co_return response;
  }
  if (is_metrics) co_return answer_with(http::status::ok, kMetricsType, parts.metrics());
  const Health health = parts.health();
  const auto status = health.well ? http::status::ok : http::status::service_unavailable;
  co_return answer_with(status, kJsonType, control::json_text(health.details) + "\n");
}

/// In the clear it is this machine alone that asks.
asio::awaitable<std::string> WebServer::Impl::why_unknown(Request request, Peer peer,
                                                          std::optional<control::Certificate> shown) {
  if (!tls) co_return "";
  std::string token{bearer_token(field(request, http::field::authorization))};
  if (token.empty() && !shown)
    co_return "give a token, as Authorization: Bearer TOKEN, or show a certificate that is known";
  const auto caller =
      co_await parts.control.caller_of(std::move(peer.name), std::move(token), std::move(shown));
  co_return caller ? "" : caller.error();
}

// The server.

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
  auto acceptor = listen(executor, "web.listen", *config.listen, address->address);
  if (!acceptor) return std::unexpected(acceptor.error());
  const auto impl =
      std::make_shared<Impl>(std::move(parts), config, limits, address->tls, *std::move(acceptor));
  return std::unique_ptr<WebServer>{new WebServer{impl}};
}

void WebServer::serve() {
  const auto admit = [server = impl_.get()](tcp::socket socket) { server->admit(std::move(socket)); };
  accept_all(std::shared_ptr<tcp::acceptor>{impl_, &impl_->acceptor}, impl_->parts.warn, "web", admit);
}

WebServer::WebServer(std::shared_ptr<Impl> impl) : impl_{std::move(impl)} {}

WebServer::~WebServer() { stop(); }

std::uint16_t WebServer::port() const { return impl_->acceptor.local_endpoint().port(); }

std::size_t WebServer::connections() const { return impl_->guests.size(); }

void WebServer::stop() {
  boost::system::error_code ignored;
  impl_->acceptor.close(ignored);
  while (!impl_->guests.empty()) impl_->close_oldest();
}

}  // namespace truepose::daemon
