#include "tools/sim/tracker/one_client_port.hpp"

#include <array>
#include <boost/asio/post.hpp>
#include <deque>
#include <utility>

#include "drivers/net/spawn.hpp"
#include "tools/steering/accept_clients.hpp"

namespace truepose::sim {

namespace asio = boost::asio;

namespace {

/// A connection with its queue of messages on the way out.
class Client : public std::enable_shared_from_this<Client> {
 public:
  explicit Client(std::unique_ptr<net::Stream> stream) : stream_{std::move(stream)} {
    net::send_at_once(*stream_);
  }

  void send(std::string bytes) {
    if (bytes.empty()) return;
    outgoing_.push_back(std::move(bytes));
    if (outgoing_.size() == 1) net::spawn(stream_->executor(), write_all(shared_from_this()));
  }

  void send_and_close(std::string bytes) {
    closing_ = true;
    send(std::move(bytes));
  }

  void close() { stream_->close(); }

  net::Stream& stream() { return *stream_; }

 private:
  static asio::awaitable<void> write_all(std::shared_ptr<Client> self) {
    while (!self->outgoing_.empty()) {
      const auto lost = co_await self->stream_->write(self->outgoing_.front());
      if (lost) co_return self->outgoing_.clear();
      self->outgoing_.pop_front();
    }
    if (!self->closing_) co_return;
    co_await self->stream_->end_writing();
    // Reading on until the peer closes keeps a reset from overtaking the last message.
    std::array<char, 256> discarded{};
    bool goes_on = true;
    while (goes_on) {
      const auto [ended, size] = co_await self->stream_->read(discarded);
      goes_on = !ended;
    }
  }

  std::unique_ptr<net::Stream> stream_;
  std::deque<std::string> outgoing_;
  bool closing_ = false;
};

}  // namespace

/// Shared with the coroutines.
class OneClientPort::State : public std::enable_shared_from_this<OneClientPort::State> {
 public:
  State(std::shared_ptr<net::Listener> listening, std::string turned_away, PortListener listener)
      : port{std::move(listening)}, turned_away_{std::move(turned_away)}, listener_{std::move(listener)} {}

  using Self = std::shared_ptr<State>;

  void accept() {
    const auto admit = [this](std::unique_ptr<net::Stream> stream) {
      // A client that left and came back at once: let the end of its old connection be seen first.
      asio::post(port->executor(),
                 [self = shared_from_this(), come = std::make_shared<Client>(std::move(stream))] {
                   self->welcome(come);
                 });
    };
    steering::accept_clients({shared_from_this(), port.get()}, "tracker", admit);
  }

  std::shared_ptr<net::Listener> port;
  std::shared_ptr<Client> client;

 private:
  void welcome(const std::shared_ptr<Client>& come) {
    if (!port->is_open()) return;
    if (client) return come->send_and_close(turned_away_);
    client = come;
    listener_.connected();
    net::spawn(port->executor(), serve(shared_from_this(), come));
  }

  static asio::awaitable<void> serve(Self self, std::shared_ptr<Client> client) {
    std::array<char, 4096> received{};
    for (bool good = true; good;) {
      const auto [error, size] = co_await client->stream().read(received);
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

OneClientPort::OneClientPort(const Machine& machine, const std::string& address, std::uint16_t port,
                             std::string turned_away, PortListener listener)
    : state_{std::make_shared<State>(steering::listen_or_throw(machine.io, address, port, machine.network),
                                     std::move(turned_away), std::move(listener))} {
  state_->accept();
}

OneClientPort::~OneClientPort() {
  drop();
  state_->port->close();
}

std::uint16_t OneClientPort::port() const { return state_->port->local().port; }

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
