#include "tools/sim/eki_server.hpp"

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <cstdio>
#include <deque>
#include <functional>
#include <utility>

#include "proto/eki/document_splitter.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

tcp::acceptor listening(const asio::any_io_executor& executor, const std::string& address,
                        std::uint16_t port) {
  const tcp::endpoint endpoint{asio::ip::make_address(address), port};
  try {
    return {executor, endpoint};
  } catch (const boost::system::system_error& e) {
    throw PortError{"EKI", port, e.code()};
  }
}

}  // namespace

/// One channel: an acceptor and at most one client.
class EkiServer::Channel : public std::enable_shared_from_this<Channel> {
 public:
  struct Handlers {
    std::function<void()> connected = [] {};
    std::function<void()> lost = [] {};
    std::function<void(const eki::ToController&)> message;
  };

  Channel(const asio::any_io_executor& executor, const std::string& address, std::uint16_t port,
          Handlers handlers)
      : acceptor_{listening(executor, address, port)}, handlers_{std::move(handlers)} {}

  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

  void accept() {
    acceptor_.async_accept([self = shared_from_this()](error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error) self->welcome(std::move(socket));
      self->accept();
    });
  }

  void send(const eki::FromController& message) {
    if (!client_) return;
    client_->outgoing.push_back(eki::encode(message));
    if (client_->outgoing.size() == 1) write(client_);
  }

  void drop(std::chrono::milliseconds duration) {
    closed_until_ = std::chrono::steady_clock::now() + duration;
    lose(client_);
  }

  /// Ends everything without telling the handlers, whose owner is going.
  void close() {
    handlers_ = {.message = [](const eki::ToController&) {}};
    acceptor_.close();
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

  void welcome(tcp::socket socket) {
    const bool closed = std::chrono::steady_clock::now() < closed_until_;
    if (client_ || closed) return;  // closes the socket
    error_code refused;
    socket.set_option(tcp::no_delay{true}, refused);
    client_ = std::make_shared<Client>(std::move(socket));
    read(client_);
    handlers_.connected();
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
      const auto message = eki::decode_to_controller(**document);
      if (message) {
        handlers_.message(*message);
      } else {
        std::fprintf(stderr, "EKI: %s\n", message.error().c_str());
      }
      if (client != client_) return;  // a handler dropped it
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
    handlers_.lost();
  }

  tcp::acceptor acceptor_;
  std::chrono::steady_clock::time_point closed_until_{};
  Handlers handlers_;
  ClientPtr client_;
};

EkiServer::EkiServer(asio::any_io_executor executor, const EkiServerOptions& options, EkiListener& listener)
    : motion_{std::make_shared<Channel>(
          executor, options.address, options.motion_port,
          Channel::Handlers{.connected = [&listener] { listener.motion_connected(); },
                            .lost = [&listener] { listener.motion_lost(); },
                            .message =
                                [&listener](const eki::ToController& message) {
                                  if (const auto* command = std::get_if<eki::Command>(&message)) {
                                    listener.command(*command);
                                  }
                                }})},
      state_{std::make_shared<Channel>(
          executor, options.address, options.state_port,
          Channel::Handlers{.message = [&listener](const eki::ToController& message) {
            if (const auto* control = std::get_if<eki::Control>(&message)) {
              listener.control(*control);
            }
          }})} {
  motion_->accept();
  state_->accept();
}

EkiServer::~EkiServer() {
  motion_->close();
  state_->close();
}

std::uint16_t EkiServer::motion_port() const { return motion_->port(); }
std::uint16_t EkiServer::state_port() const { return state_->port(); }
void EkiServer::send_motion(const eki::FromController& message) { motion_->send(message); }
void EkiServer::send_state(const eki::FromController& message) { state_->send(message); }

void EkiServer::drop(std::chrono::milliseconds duration) {
  motion_->drop(duration);
  state_->drop(duration);
}

}  // namespace truepose::sim
