#pragma once

#include <boost/asio/ssl/context.hpp>
#include <memory>

#include "drivers/net/stream.hpp"

namespace truepose::net {

/// The server's end of a connection over TLS.
class TlsStream : public Stream {
 public:
  /// Comes before the first byte.
  virtual boost::asio::awaitable<boost::system::error_code> handshake() = 0;
  /// The certificate that the client showed; null: none.
  virtual const X509* shown() const = 0;
};

/// @param under     a connection over TCP
/// @param identity  by what the client knows the server
std::unique_ptr<TlsStream> tls_stream(std::unique_ptr<Stream> under,
                                      std::shared_ptr<boost::asio::ssl::context> identity);

}  // namespace truepose::net
