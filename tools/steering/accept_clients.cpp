#include "tools/steering/accept_clients.hpp"

#include <boost/system/system_error.hpp>
#include <cstdio>
#include <utility>

namespace truepose::steering {

void accept_clients(std::shared_ptr<net::Listener> listener, std::string port,
                    std::function<void(std::unique_ptr<net::Stream>)> admit) {
  const auto warn = [port = std::move(port)](const std::string& what) {
    std::fprintf(stderr, "%s: %s\n", port.c_str(), what.c_str());
  };
  net::accept_all(std::move(listener), std::move(admit), warn);
}

std::shared_ptr<net::Listener> listen_or_throw(const boost::asio::any_io_executor& executor,
                                               const std::string& address, std::uint16_t port,
                                               const net::Network& network) {
  auto listener = network.listen_tcp(executor, address, port, {});
  if (!listener) throw boost::system::system_error{listener.error()};
  return *std::move(listener);
}

}  // namespace truepose::steering
