#include "tools/sim/eki_server.hpp"

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <cstdio>
#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include "proto/eki/document_splitter.hpp"
#include "tools/steering/accept_clients.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

using ReusePort = asio::detail::socket_option::boolean<SOL_SOCKET, SO_REUSEPORT>;

/// A socket that has the port, and does not listen.
tcp::acceptor bound_to(const asio::any_io_executor& executor, const tcp::endpoint& endpoint) {
  tcp::acceptor acceptor{executor, endpoint.protocol()};
  error_code fault;
  acceptor.set_option(tcp::acceptor::reuse_address{true}, fault);
  acceptor.set_option(ReusePort{true}, fault);
  acceptor.bind(endpoint, fault);
  if (fault) throw PortError{"EKI", endpoint.port(), fault};
  return acceptor;
}

/// Checks that no other program listens there, which binding a shared port does not show.
void expect_free(const asio::any_io_executor& executor, const tcp::endpoint& endpoint) {
  tcp::acceptor acceptor{executor, endpoint.protocol()};
  error_code fault;
  acceptor.set_option(tcp::acceptor::reuse_address{true}, fault);
  acceptor.bind(endpoint, fault);
  if (!fault) acceptor.listen(1, fault);
  if (fault) throw PortError{"EKI", endpoint.port(), fault};
}

tcp::acceptor holding(const asio::any_io_executor& executor, const std::string& address, std::uint16_t port) {
  const tcp::endpoint endpoint{asio::ip::make_address(address), port};
  expect_free(executor, endpoint);
  return bound_to(executor, endpoint);
}

}  // namespace

/// One channel: an acceptor and at most one client.
class EkiServer::Channel : public std::enable_shared_from_this<Channel> {
 public:
  Channel(const asio::any_io_executor& executor, const std::string& address, const EkiPort& port,
          EkiListener& listener)
      : name_{port.channel}, executor_{executor}, address_{address}, port_{port.port}, listener_{&listener} {
    if (!port.is_taken_late) take_port();
  }

  std::uint16_t port() const { return holder_ ? holder_->local_endpoint().port() : 0; }

  void listen(bool open) {
    if (open == std::exchange(is_wanted_, open)) return;
    if (!open) {
      if (acceptor_) acceptor_->close();
      return acceptor_.reset();
    }
    try {
      if (!holder_) take_port();
    } catch (const PortError& e) {
      std::fprintf(stderr, "EKI channel %s: %s\n", name_.c_str(), e.what());
      return;
    }
    acceptor_ = std::make_shared<tcp::acceptor>(bound_to(executor_, holder_->local_endpoint()));
    acceptor_->listen();
    steering::accept_clients(acceptor_, "EKI", [self = shared_from_this()](tcp::socket socket) {
      self->welcome(std::move(socket));
    });
  }

  void send(std::string document) {
    if (!client_) return;
    client_->outgoing.push_back(std::move(document));
    if (client_->outgoing.size() == 1) write(client_);
  }

  void drop(std::chrono::milliseconds duration) {
    closed_until_ = std::chrono::steady_clock::now() + duration;
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
    explicit Client(tcp::socket s) : socket{std::move(s)} {}
    tcp::socket socket;
    eki::DocumentSplitter splitter;
    std::array<char, 4096> incoming{};
    std::deque<std::string> outgoing;
  };
  using ClientPtr = std::shared_ptr<Client>;

  void take_port() { holder_.emplace(holding(executor_, address_, port_)); }

  void welcome(tcp::socket socket) {
    const bool closed = std::chrono::steady_clock::now() < closed_until_;
    if (client_ || closed) return;  // closes the socket
    error_code refused;
    socket.set_option(tcp::no_delay{true}, refused);
    client_ = std::make_shared<Client>(std::move(socket));
    if (!listener_->connected(name_)) return client_.reset();
    read(client_);
  }

  void read(const ClientPtr& client) {
    client->socket.async_read_some(asio::buffer(client->incoming),
                                   [self = shared_from_this(), client](error_code error, std::size_t size) {
                                     if (error) return self->lose(client);
                                     self->take({client->incoming.data(), size}, client);
                                     if (client == self->client_) self->read(client);
                                   });
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

  void write(const ClientPtr& client) {
    asio::async_write(client->socket, asio::buffer(client->outgoing.front()),
                      [self = shared_from_this(), client](error_code error, std::size_t) {
                        if (error) return self->lose(client);
                        client->outgoing.pop_front();
                        if (!client->outgoing.empty()) self->write(client);
                      });
  }

  void lose(ClientPtr client) {
    if (!client || client != client_) return;
    client_.reset();
    error_code ignored;
    client->socket.close(ignored);
    if (listener_ != nullptr) listener_->lost(name_);
  }

  std::string name_;
  asio::any_io_executor executor_;
  std::string address_;
  std::uint16_t port_;
  std::optional<tcp::acceptor> holder_;      // of the port
  bool is_wanted_ = false;                   // the program has opened the channel
  std::shared_ptr<tcp::acceptor> acceptor_;  // there while the program has opened the channel
  std::chrono::steady_clock::time_point closed_until_{};
  EkiListener* listener_;
  ClientPtr client_;
};

EkiServer::EkiServer(asio::any_io_executor executor, const std::string& address,
                     const std::vector<EkiPort>& ports, EkiListener& listener) {
  for (const EkiPort& port : ports) {
    const auto channel = std::make_shared<Channel>(executor, address, port, listener);
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
