#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <utility>

namespace truepose {

/// Sends a frame every 4 ms to a port of this machine, until its end; wants no answer.
class ScriptedController {
 public:
  using Frame = std::function<std::string(std::uint64_t cycle)>;

  /// @param address  from which it sends
  ScriptedController(std::uint16_t port, Frame frame, std::string address = "127.0.0.1")
      : thread_{[port, frame = std::move(frame), address = std::move(address)](const std::stop_token& ends) {
          using boost::asio::ip::udp;
          namespace ip = boost::asio::ip;
          boost::asio::io_context io;
          udp::socket socket{io, {ip::make_address(address), 0}};
          for (std::uint64_t cycle = 1; !ends.stop_requested(); ++cycle) {
            boost::system::error_code nobody_there_yet;
            socket.send_to(boost::asio::buffer(frame(cycle)), {ip::address_v4::loopback(), port}, 0,
                           nobody_there_yet);
            std::this_thread::sleep_for(std::chrono::milliseconds{4});
          }
        }} {}

 private:
  std::jthread thread_;
};

}  // namespace truepose
