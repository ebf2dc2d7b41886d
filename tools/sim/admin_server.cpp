#include "tools/sim/admin_server.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <utility>

#include "tools/sim/eki_server.hpp"

namespace truepose::sim {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr std::size_t kLongestLine = 64 * 1024;

class AdminClient : public std::enable_shared_from_this<AdminClient> {
 public:
  AdminClient(tcp::socket socket, std::shared_ptr<const AdminServer::Answer> answer)
      : socket_{std::move(socket)}, answer_{std::move(answer)} {}

  void serve() {
    asio::async_read_until(socket_, asio::dynamic_buffer(bytes_, kLongestLine), '\n',
                           [self = shared_from_this()](error_code error, std::size_t size) {
                             if (!error) self->reply(size);
                           });
  }

 private:
  void reply(std::size_t size) {
    reply_ = (*answer_)(bytes_.substr(0, size - 1)) + "\n";
    bytes_.erase(0, size);
    asio::async_write(socket_, asio::buffer(reply_),
                      [self = shared_from_this()](error_code error, std::size_t) {
                        if (!error) self->serve();
                      });
  }

  tcp::socket socket_;
  std::shared_ptr<const AdminServer::Answer> answer_;
  std::string bytes_, reply_;
};

tcp::acceptor listening_for_steering(const asio::any_io_executor& executor, const tcp::endpoint& endpoint) {
  try {
    return {executor, endpoint};
  } catch (const boost::system::system_error& e) {
    throw PortError{"admin", endpoint.port(), e.code()};
  }
}

}  // namespace

class AdminServer::Listener : public std::enable_shared_from_this<Listener> {
 public:
  Listener(const asio::any_io_executor& executor, const tcp::endpoint& endpoint, Answer answer)
      : acceptor_{listening_for_steering(executor, endpoint)},
        answer_{std::make_shared<const Answer>(std::move(answer))} {}

  void accept() {
    acceptor_.async_accept([self = shared_from_this()](error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (!error) std::make_shared<AdminClient>(std::move(socket), self->answer_)->serve();
      self->accept();
    });
  }
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  void close() { acceptor_.close(); }

 private:
  tcp::acceptor acceptor_;
  std::shared_ptr<const Answer> answer_;
};

AdminServer::AdminServer(asio::any_io_executor executor, const std::string& address, std::uint16_t port,
                         Answer answer)
    : listener_{std::make_shared<Listener>(executor, tcp::endpoint{asio::ip::make_address(address), port},
                                           std::move(answer))} {
  listener_->accept();
}

AdminServer::~AdminServer() { listener_->close(); }

std::uint16_t AdminServer::port() const { return listener_->port(); }

}  // namespace truepose::sim
