#include "tools/steering/line_port.hpp"

#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/write.hpp>

#include "tests/daemon/no_more_files.hpp"

namespace truepose::steering {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

TEST(LinePort, WaitsWhereNoFileIsLeftForAClientAndServesItOnceThereIs) {
  asio::io_context io;
  LinePort port{io.get_executor(), 0, [](const std::string& line) { return "got " + line; }};
  tcp::socket client{io};
  client.connect({asio::ip::address_v4::loopback(), port.port()});
  constexpr std::size_t kMany = 1000;
  std::size_t steps = 0;
  {
    const daemon::test::NoMoreFiles none;
    while (steps < kMany && io.poll_one() > 0) ++steps;
  }
  EXPECT_LT(steps, 10U) << "it asked again and again";
  asio::write(client, asio::buffer("hello\n", 6));
  char reply[16];
  std::size_t size = 0;
  client.async_read_some(asio::buffer(reply), [&](boost::system::error_code, std::size_t n) { size = n; });
  while (size == 0) io.run_one();
  EXPECT_EQ((std::string{reply, size}), "got hello\n");
}

}  // namespace
}  // namespace truepose::steering
