#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "drivers/net/listener.hpp"

namespace truepose::steering {

/// A port for who steers a program that stands in for a device: a line in, a line out, any number of clients.
/// On this machine alone: a client can stop robots and cut connections.
class LinePort {
 public:
  /// @param answer  the reply to a line, both without their ends
  using Answer = std::function<std::string(const std::string& line)>;

  /// Throws boost::system::system_error where the port cannot be listened on.
  /// @param port  0 picks a free one
  LinePort(const boost::asio::any_io_executor& executor, std::uint16_t port, Answer answer);

  ~LinePort();
  LinePort(const LinePort&) = delete;
  LinePort& operator=(const LinePort&) = delete;

  std::uint16_t port() const { return listener_->local().port; }

 private:
  std::shared_ptr<net::Listener> listener_;
};

}  // namespace truepose::steering
