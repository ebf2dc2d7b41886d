#pragma once

#include <boost/asio/awaitable.hpp>
#include <optional>
#include <string>

#include "daemon/web/http_message.hpp"
#include "daemon/web/web_server.hpp"

namespace truepose::daemon {

/// What is answered to what is asked for.
class WebAnswers {
 public:
  /// @param parts    outlives it
  /// @param origins  of pages that may use the control protocol, in addition to our own
  WebAnswers(const WebServerParts& parts, std::vector<std::string> origins, bool tls)
      : parts_{parts}, origins_{std::move(origins)}, tls_{tls} {}

  /// Whether it asks for the control protocol over WebSocket, and may.
  bool is_upgrade(const HttpRequest& request) const;
  /// @param shown  the client's certificate
  boost::asio::awaitable<HttpAnswer> answer(HttpRequest request, Peer peer,
                                            std::optional<control::Certificate> shown) const;

 private:
  /// Why a request is none that this server takes; empty: it is.
  std::string fault_of(const HttpRequest& request) const;
  boost::asio::awaitable<HttpAnswer> answer_to_known(HttpRequest request, Peer peer,
                                                     std::optional<control::Certificate> shown) const;
  boost::asio::awaitable<std::string> why_unknown(HttpRequest request, Peer peer,
                                                  std::optional<control::Certificate> shown) const;

  const WebServerParts& parts_;
  std::vector<std::string> origins_;
  bool tls_;
};

}  // namespace truepose::daemon
