#include "tools/steering/accept_clients.hpp"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <cstdio>
#include <utility>

#include "drivers/accept_all.hpp"

namespace truepose::steering {

void accept_clients(std::shared_ptr<boost::asio::ip::tcp::acceptor> acceptor, std::string port,
                    std::function<void(boost::asio::ip::tcp::socket)> admit) {
  const auto executor = acceptor->get_executor();
  const auto warn = [port = std::move(port)](const std::string& what) {
    std::fprintf(stderr, "%s: %s\n", port.c_str(), what.c_str());
  };
  boost::asio::co_spawn(executor, drivers::accept_all(std::move(acceptor), std::move(admit), warn),
                        boost::asio::detached);
}

}  // namespace truepose::steering
