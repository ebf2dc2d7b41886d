#include "daemon/web/web_answers.hpp"

#include <boost/beast/websocket/rfc6455.hpp>
#include <utility>

#include "daemon/web/web_pages.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
namespace http = boost::beast::http;

bool WebAnswers::is_upgrade(const HttpRequest& request) const {
  return boost::beast::websocket::is_upgrade(request) && target_of(request) == "/rpc" &&
         fault_of(request).empty();
}

std::string WebAnswers::fault_of(const HttpRequest& request) const {
  const std::string_view host = field(request, http::field::host);
  // Over TLS it is the certificate by which a browser knows whose server it talks to.
  if (!tls_ && !is_loopback_name(host))
    return "ask for 127.0.0.1 or localhost: this server is this machine's own";
  if (target_of(request) != "/rpc") return {};
  const std::string_view origin = field(request, http::field::origin);
  if (origin_may(origin, (tls_ ? "https://" : "http://") + std::string{host}, origins_)) return {};
  return "pages of " + std::string{origin.substr(0, 200)} +
         " may not speak the control protocol; list the origin in the cell file's web.origins";
}

asio::awaitable<HttpAnswer> WebAnswers::answer(HttpRequest request, Peer peer,
                                               std::optional<control::Certificate> shown) const {
  if (std::string fault = fault_of(request); !fault.empty())
    co_return refusal(http::status::forbidden, fault);
  if (request.method() != http::verb::head && request.method() != http::verb::get) {
    HttpAnswer answer = refusal(http::status::method_not_allowed, "only GET and HEAD are served here");
    answer.fields = "Allow: GET, HEAD\r\n";
    co_return answer;
  }
  const std::string_view target = target_of(request).substr(0, target_of(request).find('?'));
  HttpAnswer answer = refusal(http::status::not_found, "served are /, /metrics, /healthz and /rpc");
  if (target == "/") {
    answer = {http::status::ok, "text/html; charset=utf-8", std::string{dashboard_page()}};
  } else if (target == "/rpc") {
    answer = refusal(http::status::upgrade_required, "the control protocol is spoken over WebSocket here");
    answer.fields = "Upgrade: websocket\r\n";
  } else if (target == "/metrics" || target == "/healthz") {
    answer = co_await answer_to_known(std::move(request), std::move(peer), std::move(shown));
  }
  co_return answer;
}

asio::awaitable<HttpAnswer> WebAnswers::answer_to_known(HttpRequest request, Peer peer,
                                                        std::optional<control::Certificate> shown) const {
  const bool is_metrics = target_of(request).starts_with("/metrics");
  const std::string unknown = co_await why_unknown(std::move(request), std::move(peer), std::move(shown));
  if (!unknown.empty()) {
    HttpAnswer answer = refusal(http::status::unauthorized, unknown);
    answer.fields = "WWW-Authenticate: Bearer realm=\"truepose\"\r\n";
    co_return answer;
  }
  if (is_metrics)
    co_return HttpAnswer{http::status::ok, "text/plain; version=0.0.4; charset=utf-8", parts_.metrics()};
  const Health health = parts_.health();
  const auto status = health.well() ? http::status::ok : http::status::service_unavailable;
  co_return HttpAnswer{status, "application/json", control::json_text(record::to_json(health)) + "\n"};
}

/// In the clear it is this machine alone that asks.
asio::awaitable<std::string> WebAnswers::why_unknown(HttpRequest request, Peer peer,
                                                     std::optional<control::Certificate> shown) const {
  if (!tls_) co_return "";
  std::string token{bearer_token(field(request, http::field::authorization))};
  if (token.empty() && !shown)
    co_return "give a token, as Authorization: Bearer TOKEN, or show a certificate that is known";
  const auto caller =
      co_await parts_.control.caller_of(std::move(peer.name), std::move(token), std::move(shown));
  co_return caller ? "" : caller.error();
}

}  // namespace truepose::daemon
