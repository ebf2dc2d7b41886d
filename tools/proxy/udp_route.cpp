#include "tools/proxy/udp_route.hpp"

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <map>
#include <sstream>

namespace truepose::proxy {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

namespace {

constexpr std::size_t kClients = 256;  // others are dropped, so that a flood takes no more sockets

std::string text(const udp::endpoint& endpoint) { return (std::ostringstream{} << endpoint).str(); }

/// Lives until its sockets are closed and what it delays has gone out.
class UdpForwarder : public std::enable_shared_from_this<UdpForwarder> {
 public:
  UdpForwarder(const asio::any_io_executor& executor, const udp::endpoint& listen,
               const udp::endpoint& target, Random& seeds)
      : ways{seeds}, target_{target}, socket_{executor, listen} {}

  void receive() {
    socket_.async_receive_from(asio::buffer(buffer_), sender_,
                               [self = shared_from_this()](error_code error, std::size_t size) {
                                 if (error == asio::error::operation_aborted) return;
                                 if (!error) self->from_client({self->buffer_.data(), size});
                                 self->receive();
                               });
  }

  void close() {
    socket_.close();
    for (auto& [endpoint, client] : clients_) client->socket.close();
    clients_.clear();
  }

  udp::endpoint listens() const { return socket_.local_endpoint(); }
  const udp::endpoint& target() const { return target_; }
  std::size_t clients() const { return clients_.size(); }

  Ways ways;

 private:
  using Buffer = std::array<char, 64 * 1024>;

  /// The target knows each client by a port of its own.
  struct Client {
    udp::socket socket;
    udp::endpoint endpoint;
    Buffer buffer{};
  };
  using ClientPtr = std::shared_ptr<Client>;

  void from_client(std::string_view bytes) {
    const ClientPtr client = client_of(sender_);
    if (!client) return;
    forward(ways.to_target.datagram(bytes), [client](const std::string& datagram) {
      error_code ignored;  // an absent receiver is the devices' own matter
      client->socket.send(asio::buffer(datagram), 0, ignored);
    });
  }

  ClientPtr client_of(const udp::endpoint& endpoint) {
    const auto known = clients_.find(endpoint);
    if (known != clients_.end()) return known->second;
    if (clients_.size() == kClients) return nullptr;
    const auto client =
        std::make_shared<Client>(udp::socket{socket_.get_executor(), target_.protocol()}, endpoint);
    error_code unreachable;
    client->socket.connect(target_, unreachable);
    if (unreachable) return nullptr;
    clients_.emplace(endpoint, client);
    receive_reply(client);
    return client;
  }

  void receive_reply(const ClientPtr& client) {
    client->socket.async_receive(asio::buffer(client->buffer),
                                 [self = shared_from_this(), client](error_code error, std::size_t size) {
                                   if (error == asio::error::operation_aborted) return;
                                   if (!error)
                                     self->from_target({client->buffer.data(), size}, client->endpoint);
                                   self->receive_reply(client);
                                 });
  }

  void from_target(std::string_view bytes, const udp::endpoint& client) {
    forward(ways.to_client.datagram(bytes), [self = shared_from_this(), client](const std::string& datagram) {
      error_code ignored;
      self->socket_.send_to(asio::buffer(datagram), client, 0, ignored);
    });
  }

  void forward(std::vector<FaultyWay::Outgoing> datagrams,
               const std::function<void(const std::string&)>& send) {
    for (FaultyWay::Outgoing& datagram : datagrams) {
      if (datagram.delay.count() == 0) {
        send(datagram.bytes);
        continue;
      }
      const auto timer = std::make_shared<asio::steady_timer>(socket_.get_executor(), datagram.delay);
      timer->async_wait([timer, send, bytes = std::move(datagram.bytes)](error_code) { send(bytes); });
    }
  }

  udp::endpoint target_;
  udp::socket socket_;
  udp::endpoint sender_;
  Buffer buffer_{};
  std::map<udp::endpoint, ClientPtr> clients_;
};

class UdpRoute : public Route {
 public:
  explicit UdpRoute(std::shared_ptr<UdpForwarder> forwarder) : forwarder_{std::move(forwarder)} {
    forwarder_->receive();
  }
  ~UdpRoute() override { forwarder_->close(); }

  std::string listens() const override { return text(forwarder_->listens()); }
  void apply(const Command& command) override { forwarder_->ways.apply(command); }
  RouteStatistics statistics() const override {
    return {.protocol = "udp",
            .listen = listens(),
            .target = text(forwarder_->target()),
            .clients = forwarder_->clients(),
            .to_target = forwarder_->ways.to_target.counters(),
            .to_client = forwarder_->ways.to_client.counters()};
  }

 private:
  std::shared_ptr<UdpForwarder> forwarder_;
};

}  // namespace

std::unique_ptr<Route> udp_route(const asio::any_io_executor& executor, const udp::endpoint& listen,
                                 const udp::endpoint& target, Random& seeds) {
  return std::make_unique<UdpRoute>(std::make_shared<UdpForwarder>(executor, listen, target, seeds));
}

}  // namespace truepose::proxy
