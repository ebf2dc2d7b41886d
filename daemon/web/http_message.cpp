#include "daemon/web/http_message.hpp"

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>

namespace truepose::daemon {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using boost::system::error_code;

namespace {

constexpr std::size_t kMostHeaderBytes = 8 * 1024;

std::string_view view(boost::beast::string_view text) { return {text.data(), text.size()}; }

/// What is answered to something that is no request.
std::optional<HttpAnswer> complaint(error_code error) {
  if (error == http::error::header_limit)
    return refusal(http::status::request_header_fields_too_large, "the header is too long");
  if (error == http::error::unexpected_body || error == http::error::body_limit)
    return refusal(http::status::payload_too_large, "no request here has a body");
  return refusal(http::status::bad_request, "this is no HTTP request: " + error.message());
}

}  // namespace

std::string_view target_of(const HttpRequest& request) { return view(request.target()); }
std::string_view field(const HttpRequest& request, http::field name) { return view(request[name]); }

HttpAnswer refusal(http::status status, const std::string& why) {
  return {status, "text/plain; charset=utf-8", why + "\n"};
}

std::string bytes_of(const HttpAnswer& answer, bool keep_alive, bool has_body) {
  std::string bytes = "HTTP/1.1 " + std::to_string(static_cast<unsigned>(answer.status)) + " ";
  bytes += view(http::obsolete_reason(answer.status));
  bytes += "\r\nContent-Type: ";
  bytes += answer.type;
  // The page has its script and style in itself, and talks to the server that it is from.
  bytes +=
      "\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nContent-Security-Policy: "
      "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self'; img-src data:; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\nContent-Length: ";
  bytes += std::to_string(answer.body.size()) + "\r\n" + answer.fields;
  bytes += keep_alive ? "\r\n" : "Connection: close\r\n\r\n";
  if (has_body) bytes += answer.body;
  return bytes;
}

asio::awaitable<HttpReader::Next> HttpReader::next(Connection& connection) {
  http::request_parser<http::empty_body> parser;
  parser.header_limit(kMostHeaderBytes);
  parser.body_limit(std::uint64_t{0});
  parser.eager(true);
  std::array<char, 4096> piece;
  while (!parser.is_done()) {
    error_code error = http::error::need_more;
    if (!come_.empty()) come_.erase(0, parser.put(asio::const_buffer{come_.data(), come_.size()}, error));
    if (error == http::error::need_more) {
      const std::size_t size = co_await connection.read_some(asio::buffer(piece));
      if (size == 0) co_return std::unexpected(std::nullopt);
      come_.append(piece.data(), size);
    } else if (error) {
      co_return std::unexpected(complaint(error));
    }
  }
  co_return parser.release();
}

}  // namespace truepose::daemon
