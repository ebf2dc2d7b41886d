#include "drivers/net/tls_stream.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <utility>

#include "drivers/net/socket_stream.hpp"

namespace truepose::net {

namespace {

namespace asio = boost::asio;
using boost::system::error_code;

class SocketTlsStream final : public TlsStream {
 public:
  SocketTlsStream(SocketStream& under, std::shared_ptr<asio::ssl::context> identity)
      : local_{under.local()},
        remote_{under.remote()},
        identity_{std::move(identity)},
        stream_{under.release(), *identity_} {}

  asio::any_io_executor executor() override { return stream_.get_executor(); }
  asio::awaitable<error_code> connect(std::string, std::uint16_t) override {
    co_return asio::error::operation_not_supported;
  }
  asio::awaitable<error_code> handshake() override {
    const auto [error] = co_await stream_.async_handshake(asio::ssl::stream_base::server, kAsTuple);
    co_return error;
  }
  const X509* shown() const override { return SSL_get0_peer_certificate(stream_.native_handle()); }
  asio::awaitable<Received> read(std::span<char> into) override {
    const auto [error, size] =
        co_await stream_.async_read_some(asio::buffer(into.data(), into.size()), kAsTuple);
    co_return Received{error, size};
  }
  asio::awaitable<error_code> write(std::string_view bytes) override {
    const auto [error, size] = co_await asio::async_write(stream_, asio::buffer(bytes), kAsTuple);
    co_return error;
  }
  asio::awaitable<void> end_writing() override {
    const auto said = co_await stream_.async_shutdown(kAsTuple);
    static_cast<void>(said);
  }
  void end_reading() override {
    error_code gone;
    stream_.next_layer().shutdown(asio::socket_base::shutdown_receive, gone);
  }
  void close() noexcept override {
    error_code gone;
    stream_.next_layer().close(gone);
  }
  bool is_open() const override { return stream_.next_layer().is_open(); }
  End local() const override { return local_; }
  End remote() const override { return remote_; }
  int handle() const override { return is_open() ? stream_.next_layer().native_handle() : -1; }

 private:
  End local_, remote_;
  std::shared_ptr<asio::ssl::context> identity_;  ///< outlives one that takes its place meanwhile
  mutable asio::ssl::stream<SocketStream::Socket> stream_;
};

}  // namespace

std::unique_ptr<TlsStream> tls_stream(std::unique_ptr<Stream> under,
                                      std::shared_ptr<asio::ssl::context> identity) {
  return std::make_unique<SocketTlsStream>(dynamic_cast<SocketStream&>(*under), std::move(identity));
}

}  // namespace truepose::net
