#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace truepose::sim {

/// A TCP port for who steers a simulator: a line in, a line out, any number of clients.
class AdminServer {
 public:
  /// @param answer  the reply to a line, without its end
  using Answer = std::function<std::string(const std::string& line)>;

  /// Listens at once. Throws PortError.
  /// @param port  0 picks a free one
  AdminServer(boost::asio::any_io_executor executor, const std::string& address, std::uint16_t port,
              Answer answer);
  ~AdminServer();

  std::uint16_t port() const;

 private:
  class Listener;
  std::shared_ptr<Listener> listener_;
};

}  // namespace truepose::sim
