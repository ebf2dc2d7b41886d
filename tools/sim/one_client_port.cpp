#include "tools/sim/one_client_port.hpp"

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <deque>
#include <utility>

#include "tools/steering/accept_clients.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr auto kToResult = asio::as_tuple(asio::use_awaitable);

/// A connection with its queue of messages on the way out.
class Client : public std::enable_shared_from_this<Client> {
 public:
  explicit Client(tcp::socket socket) : socket_{std::move(socket)} {
    error_code ignored;
    socket_.set_option(tcp::no_delay{true}, ignored);
  }

  void send(std::string bytes) {
    if (bytes.empty()) return;
    outgoing_.push_back(std::move(bytes));
    if (outgoing_.size() == 1) write_next();
  }

  void send_and_close(std::string bytes) {
    closing_ = true;
    send(std::move(bytes));
  }

  void close() {
    error_code ignored;
    socket_.close(ignored);
  }

  tcp::socket& socket() { return socket_; }

 private:
  void write_next() {
    asio::async_write(socket_, asio::buffer(outgoing_.front()),
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (error) return self->outgoing_.clear();
                        self->outgoing_.pop_front();
                        if (!self->outgoing_.empty()) return self->write_next();
                        if (self->closing_) self->socket_.shutdown(tcp::socket::shutdown_send, error);
                        if (self->closing_) self->discard();
                      });
  }

  /// Reading on until the peer closes keeps a reset from overtaking the last message.
  void discard() {
    socket_.async_read_some(asio::buffer(discarded_),
                            [self = shared_from_this()](error_code error, std::size_t) {
                              if (!error) self->discard();
                            });
  }

  tcp::socket socket_;
  std::deque<std::string> outgoing_;
  std::array<char, 256> discarded_{};
  bool closing_ = false;
};

}  // namespace

/// Shared with the coroutines.
class OneClientPort::State : public std::enable_shared_from_this<OneClientPort::State> {
 public:
  State(const asio::any_io_executor& executor, const std::string& address, std::uint16_t port,
        std::string turned_away, PortListener listener)
      : acceptor{executor, tcp::endpoint{asio::ip::make_address(address), port}},
        turned_away_{std::move(turned_away)},
        listener_{std::move(listener)} {}

  using Self = std::shared_ptr<State>;

  void accept() {
    steering::accept_clients({shared_from_this(), &acceptor}, "tracker", [this](tcp::socket socket) {
      // A client that left and came back at once: let the end of its old connection be seen first.
      asio::post(acceptor.get_executor(),
                 [self = shared_from_this(), come = std::make_shared<Client>(std::move(socket))] {
                   self->welcome(come);
                 });
    });
  }

  tcp::acceptor acceptor;
  std::shared_ptr<Client> client;

 private:
  void welcome(const std::shared_ptr<Client>& come) {
    if (!acceptor.is_open()) return;
    if (client) return come->send_and_close(turned_away_);
    client = come;
    listener_.connected();
    asio::co_spawn(acceptor.get_executor(), serve(shared_from_this(), come), asio::detached);
  }

  static asio::awaitable<void> serve(Self self, std::shared_ptr<Client> client) {
    std::array<char, 4096> received{};
    for (bool good = true; good;) {
      auto [error, size] = co_await client->socket().async_read_some(asio::buffer(received), kToResult);
      if (error || self->client != client) break;
      good = self->listener_.received({received.data(), size});
    }
    client->close();
    if (self->client != client) co_return;
    self->client.reset();
    self->listener_.lost();
  }

  const std::string turned_away_;
  const PortListener listener_;
};

OneClientPort::OneClientPort(asio::any_io_executor executor, const std::string& address, std::uint16_t port,
                             std::string turned_away, PortListener listener)
    : state_{std::make_shared<State>(executor, address, port, std::move(turned_away), std::move(listener))} {
  state_->accept();
}

OneClientPort::~OneClientPort() {
  drop();
  error_code ignored;
  state_->acceptor.close(ignored);
}

std::uint16_t OneClientPort::port() const { return state_->acceptor.local_endpoint().port(); }

void OneClientPort::send(std::string bytes) {
  if (state_->client) state_->client->send(std::move(bytes));
}

void OneClientPort::send_and_close(std::string bytes) {
  if (state_->client) state_->client->send_and_close(std::move(bytes));
}

void OneClientPort::drop() {
  if (state_->client) state_->client->close();
  state_->client.reset();
}

}  // namespace truepose::sim
