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

  ScriptedController(std::uint16_t port, Frame frame)
      : thread_{[port, frame = std::move(frame)](const std::stop_token& ends) {
          using boost::asio::ip::udp;
          namespace ip = boost::asio::ip;
          boost::asio::io_context io;
          udp::socket socket{io, {ip::address_v4::loopback(), 0}};
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
