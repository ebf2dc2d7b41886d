#include "tools/steering/line_port.hpp"

#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <string>

#include "tests/daemon/no_more_files.hpp"

namespace truepose::steering {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

std::string answer_to(tcp::socket& client, asio::io_context& io, const std::string& line) {
  asio::write(client, asio::buffer(line + "\n"));
  char reply[16];
  std::size_t size = 0;
  client.async_read_some(asio::buffer(reply), [&](boost::system::error_code, std::size_t n) { size = n; });
  while (size == 0) io.run_one();
  return {reply, size};
}

TEST(LinePort, WaitsWhereNoFileIsLeftForAClientAndServesItOnceThereIs) {
  asio::io_context io;
  LinePort port{io.get_executor(), 0, [](const std::string& line) { return "got " + line; }};
  const tcp::endpoint at{asio::ip::address_v4::loopback(), port.port()};
  tcp::socket first{io}, client{io};
  first.connect(at);
  // A sanitizer, too, needs files when it meets a type for the first time: of sockets and of timers here.
  EXPECT_EQ(answer_to(first, io, "hello"), "got hello\n");
  asio::steady_timer{io, std::chrono::seconds{0}}.async_wait([](boost::system::error_code) {});
  io.run_one();
  client.connect(at);
  constexpr std::size_t kMany = 1000;
  std::size_t steps = 0;
  {
    const daemon::test::NoMoreFiles none;
    while (steps < kMany && io.poll_one() > 0) ++steps;
  }
  EXPECT_LT(steps, 10U) << "it asked again and again";
  EXPECT_EQ(answer_to(client, io, "hello"), "got hello\n");
}

}  // namespace
}  // namespace truepose::steering
