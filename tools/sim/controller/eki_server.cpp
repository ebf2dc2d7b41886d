#include "tools/sim/controller/eki_server.hpp"

#include <array>
#include <cstdio>
#include <deque>
#include <functional>
#include <utility>

#include "drivers/net/spawn.hpp"
#include "proto/eki/document_splitter.hpp"
#include "tools/steering/accept_clients.hpp"

namespace truepose::sim {

namespace asio = boost::asio;

/// One channel: a port and at most one client.
class EkiServer::Channel : public std::enable_shared_from_this<Channel> {
 public:
  Channel(const Machine& machine, const std::string& address, const EkiPort& port, EkiListener& listener)
      : name_{port.channel}, machine_{machine}, address_{address}, port_{port.port}, listener_{&listener} {
    if (!port.is_taken_late) take_port();
  }

  std::uint16_t port() const { return held_port_ ? held_port_->port() : 0; }

  void listen(bool open) {
    if (open == std::exchange(is_wanted_, open)) return;
    if (!open) {
      if (open_port_) open_port_->close();
      return open_port_.reset();
    }
    try {
      if (!held_port_) take_port();
      auto listener = machine_.network.listen_tcp(machine_.io, address_, port(), {.shares_port = true});
      if (!listener) throw PortError{"EKI", port(), listener.error()};
      open_port_ = *std::move(listener);
    } catch (const PortError& e) {
      std::fprintf(stderr, "EKI channel %s: %s\n", name_.c_str(), e.what());
      return;
    }
    const auto admit = [self = shared_from_this()](std::unique_ptr<net::Stream> stream) {
      self->welcome(std::move(stream));
    };
    steering::accept_clients(open_port_, "EKI", admit);
  }

  void send(std::string document) {
    if (!client_) return;
    client_->outgoing.push_back(std::move(document));
    if (client_->outgoing.size() == 1) net::spawn(machine_.io, write(shared_from_this(), client_));
  }

  void drop(std::chrono::milliseconds duration) {
    closed_until_ = machine_.clock.now() + duration;
    lose(client_);
  }

  void close_client() { lose(client_); }

  /// Ends everything without telling the listener, who is going.
  void end() {
    listener_ = nullptr;
    listen(false);
    lose(client_);
  }

 private:
  struct Client {
    std::unique_ptr<net::Stream> stream;
    eki::DocumentSplitter splitter{};
    std::deque<std::string> outgoing{};
  };
  using ClientPtr = std::shared_ptr<Client>;

  void take_port() {
    auto held = machine_.network.hold_tcp(machine_.io, address_, port_);
    if (!held) throw PortError{"EKI", port_, held.error()};
    held_port_ = *std::move(held);
  }

  void welcome(std::unique_ptr<net::Stream> stream) {
    const bool closed = machine_.clock.now() < closed_until_;
    if (client_ || closed) return;  // closes it
    net::send_at_once(*stream);
    client_ = std::make_shared<Client>(std::move(stream));
    if (!listener_->connected(name_)) return client_.reset();
    net::spawn(machine_.io, read(shared_from_this(), client_));
  }

  static asio::awaitable<void> read(std::shared_ptr<Channel> self, ClientPtr client) {
    std::array<char, 4096> incoming{};
    while (client == self->client_) {
      const auto [lost, size] = co_await client->stream->read(incoming);
      if (lost || client != self->client_) co_return self->lose(client);
      self->take({incoming.data(), size}, client);
    }
  }

  void take(std::string_view bytes, const ClientPtr& client) {
    client->splitter.feed(bytes);
    for (;;) {
      const auto document = client->splitter.next();
      if (!document) {
        std::fprintf(stderr, "EKI: %s; the connection is closed\n", document.error().c_str());
        return lose(client);
      }
      if (!*document) return;
      listener_->received(name_, **document);
      if (client != client_) return;  // the listener dropped it
    }
  }

  static asio::awaitable<void> write(std::shared_ptr<Channel> self, ClientPtr client) {
    while (!client->outgoing.empty()) {
      const auto lost = co_await client->stream->write(client->outgoing.front());
      if (lost) co_return self->lose(client);
      client->outgoing.pop_front();
    }
  }

  void lose(ClientPtr client) {
    if (!client || client != client_) return;
    client_.reset();
    client->stream->close();
    if (listener_ != nullptr) listener_->lost(name_);
  }

  std::string name_;
  const Machine machine_;
  std::string address_;
  std::uint16_t port_;
  std::unique_ptr<net::HeldPort> held_port_;
  bool is_wanted_ = false;                    // the program has opened the channel
  std::shared_ptr<net::Listener> open_port_;  // there while the program has opened the channel
  drivers::TimePoint closed_until_{};
  EkiListener* listener_;
  ClientPtr client_;
};

EkiServer::EkiServer(const Machine& machine, const std::string& address, const std::vector<EkiPort>& ports,
                     EkiListener& listener) {
  for (const EkiPort& port : ports) {
    const auto channel = std::make_shared<Channel>(machine, address, port, listener);
    channels_.emplace(port.channel, channel);
  }
}

EkiServer::~EkiServer() {
  for (const auto& [name, channel] : channels_) channel->end();
}

std::uint16_t EkiServer::port(std::string_view channel) const {
  const auto found = channels_.find(channel);
  return found == channels_.end() ? 0 : found->second->port();
}

void EkiServer::send(std::string_view channel, std::string document) {
  channels_.find(channel)->second->send(std::move(document));
}

void EkiServer::listen(std::string_view channel, bool open) { channels_.find(channel)->second->listen(open); }

void EkiServer::close(std::string_view channel) { channels_.find(channel)->second->close_client(); }

void EkiServer::drop(std::chrono::milliseconds duration) {
  for (const auto& [name, channel] : channels_) channel->drop(duration);
}

}  // namespace truepose::sim
