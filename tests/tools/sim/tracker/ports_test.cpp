#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "tests/no_more_files.hpp"
#include "tools/sim/controller/eki_server.hpp"
#include "tools/sim/tracker/one_client_port.hpp"

namespace truepose::sim {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

struct CountedClients final : EkiListener {
  bool connected(const std::string&) override { return ++came > 0; }
  void lost(const std::string&) override { ++left; }
  void received(const std::string&, std::string_view) override {}

  int came = 0, left = 0;
};

/// @param clients  of the port that is listened on
void expect_patience(asio::io_context& io, std::uint16_t port, const CountedClients& clients) {
  const auto until = [&io](const std::function<bool()>& done) {
    while (!done()) io.run_one();
  };
  tcp::socket first{io}, second{io};
  first.connect({asio::ip::address_v4::loopback(), port});
  until([&] { return clients.came == 1; });
  first.close();
  until([&] { return clients.left == 1; });
  EXPECT_LT(steps_without_files(io, second, port), 10U) << "it asked again and again";
  until([&] { return clients.came == 2; });
}

TEST(EkiServer, WaitsWhereNoFileIsLeftForAClientAndServesItOnceThereIs) {
  drivers::SteadyClock clock;
  asio::io_context io;
  CountedClients clients;
  EkiServer server{{.io = io.get_executor(), .clock = clock}, "127.0.0.1", {{"Motion"}}, clients};
  server.listen("Motion", true);
  expect_patience(io, server.port("Motion"), clients);
}

TEST(OneClientPort, WaitsWhereNoFileIsLeftForAClientAndServesItOnceThereIs) {
  drivers::SteadyClock clock;
  asio::io_context io;
  CountedClients clients;
  OneClientPort port{{.io = io.get_executor(), .clock = clock},
                     "127.0.0.1",
                     0,
                     "busy",
                     {.connected = [&] { ++clients.came; },
                      .received = [](std::string_view) { return true; },
                      .lost = [&] { ++clients.left; }}};
  expect_patience(io, port.port(), clients);
}

}  // namespace
}  // namespace truepose::sim
