#include "tools/steering/accept_clients.hpp"

#include <cstdio>
#include <utility>

#include "drivers/accept_all.hpp"

namespace truepose::steering {

void accept_clients(std::shared_ptr<boost::asio::ip::tcp::acceptor> acceptor, std::string port,
                    std::function<void(boost::asio::ip::tcp::socket)> admit) {
  const auto warn = [port = std::move(port)](const std::string& what) {
    std::fprintf(stderr, "%s: %s\n", port.c_str(), what.c_str());
  };
  drivers::accept_all(std::move(acceptor), std::move(admit), warn);
}

}  // namespace truepose::steering
