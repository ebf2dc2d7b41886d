#include "tools/steering/line_port.hpp"

#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/write.hpp>
#include <string>

#include "tests/no_more_files.hpp"

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
  tcp::socket first{io}, client{io};
  first.connect({asio::ip::address_v4::loopback(), port.port()});
  EXPECT_EQ(answer_to(first, io, "hello"), "got hello\n");
  EXPECT_LT(steps_without_files(io, client, port.port()), 10U) << "it asked again and again";
  EXPECT_EQ(answer_to(client, io, "hello"), "got hello\n");
}

}  // namespace
}  // namespace truepose::steering
