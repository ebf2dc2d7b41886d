#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/ip/tcp.hpp>

#include "tools/proxy/proxy.hpp"

namespace truepose::proxy {

/// Obeys lines of JSON, one reply line each. On this machine alone: whoever reaches it can cut connections.
class AdminPort {
 public:
  /// Throws boost::system::system_error where the port cannot be listened on.
  AdminPort(const boost::asio::any_io_executor& executor, std::uint16_t port, Proxy& proxy);

  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  void accept();

  boost::asio::ip::tcp::acceptor acceptor_;
  Proxy& proxy_;
};

}  // namespace truepose::proxy
