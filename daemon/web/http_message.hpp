#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/status.hpp>
#include <expected>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/control/connection.hpp"

namespace truepose::daemon {

/// A request without a body: no other is served.
using HttpRequest = boost::beast::http::request<boost::beast::http::empty_body>;

std::string_view target_of(const HttpRequest& request);
std::string_view field(const HttpRequest& request, boost::beast::http::field name);

struct HttpAnswer {
  boost::beast::http::status status;
  std::string_view type;  ///< of the body, which is a literal
  std::string body;
  std::string fields{};  ///< further lines of the header: "Allow: GET, HEAD\r\n"
};

HttpAnswer refusal(boost::beast::http::status status, const std::string& why);

/// The bytes of an answer over HTTP/1.1.
/// @param has_body  false for HEAD: the header has the length of the body, which is left out
std::string bytes_of(const HttpAnswer& answer, bool keep_alive, bool has_body);

/// Reads the requests of one connection, one behind the other.
class HttpReader {
 public:
  /// A request; or the answer to what is none; or neither: the client is gone.
  using Next = std::expected<HttpRequest, std::optional<HttpAnswer>>;
  boost::asio::awaitable<Next> next(Connection& connection);
  /// What came behind the last request.
  const std::string& rest() const { return come_; }

 private:
  std::string come_;
};

}  // namespace truepose::daemon
