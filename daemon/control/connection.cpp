#include "daemon/control/connection.hpp"

#include <boost/asio/ip/address.hpp>
#include <utility>

#include "drivers/net/tls_stream.hpp"

namespace truepose::daemon {

namespace {

namespace asio = boost::asio;
using asio::awaitable;
using Opened = std::expected<std::optional<control::Certificate>, std::string>;

class PlainConnection : public Connection {
 public:
  explicit PlainConnection(std::unique_ptr<net::Stream> stream) : stream_{std::move(stream)} {}

  asio::any_io_executor executor() override { return stream_->executor(); }
  awaitable<Opened> open() override { co_return Opened{}; }
  awaitable<std::size_t> read_some(asio::mutable_buffer buffer) override {
    const auto [error, size] = co_await stream_->read({static_cast<char*>(buffer.data()), buffer.size()});
    co_return error ? 0 : size;
  }
  awaitable<bool> write(asio::const_buffer bytes) override {
    const auto error = co_await stream_->write({static_cast<const char*>(bytes.data()), bytes.size()});
    co_return !error;
  }
  awaitable<void> end_writing() override { return stream_->end_writing(); }
  void end_reading() override { stream_->end_reading(); }
  void close() override { net::close_in_order(*stream_); }

 private:
  std::unique_ptr<net::Stream> stream_;
};

class TlsConnection final : public PlainConnection {
 public:
  explicit TlsConnection(std::unique_ptr<net::TlsStream> stream)
      : TlsConnection{*stream, std::move(stream)} {}

  awaitable<Opened> open() override {
    const auto error = co_await tls_.handshake();
    if (error) co_return std::unexpected(error.message());
    const X509* const shown = tls_.shown();
    if (!shown) co_return Opened{};
    co_return control::facts_of(*shown);
  }

 private:
  TlsConnection(net::TlsStream& tls, std::unique_ptr<net::Stream> stream)
      : PlainConnection{std::move(stream)}, tls_{tls} {}

  net::TlsStream& tls_;
};

}  // namespace

Peer Peer::of(const net::Stream& stream) {
  // A client whose machine was switched off says nothing of it, and events alone may come after hours.
  constexpr int kSilence_s = 30, kAgain_s = 10, kTimes = 3;
  net::keep_alive(stream, kSilence_s, kAgain_s, kTimes);
  const net::Stream::End theirs = stream.remote(), ours = stream.local();
  boost::system::error_code gone;
  // Every user of this machine has all of its loopback addresses.
  const bool is_near = asio::ip::make_address(theirs.host, gone).is_loopback();
  const std::string name = theirs.host.empty() ? "a client that has gone" : theirs.host;
  return {is_near ? "loopback" : name, ours.host + " " + std::to_string(ours.port)};
}

std::unique_ptr<Connection> plain_connection(std::unique_ptr<net::Stream> stream) {
  return std::make_unique<PlainConnection>(std::move(stream));
}

std::unique_ptr<Connection> tls_connection(std::unique_ptr<net::Stream> stream,
                                           std::shared_ptr<asio::ssl::context> identity) {
  return std::make_unique<TlsConnection>(net::tls_stream(std::move(stream), std::move(identity)));
}

}  // namespace truepose::daemon
