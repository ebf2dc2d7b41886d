// truepose-proxy as its users start it.
#include "tests/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/write.hpp>
#include <boost/json/parse.hpp>

#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using asio::ip::tcp;
using asio::ip::udp;
using testing::HasSubstr;

const asio::ip::address kHere = asio::ip::address_v4::loopback();

/// What a program wrote into its ready file; null where it ended without.
json::value ready(Process& program, const std::filesystem::path& file) {
  const std::string text = program.ready(file);
  return text.empty() ? nullptr : json::parse(text);
}

TEST(TheProxyProgram, TakesFaultsAtItsStartAndWhileItRuns) {
  const TempFolder folder;
  asio::io_context io;
  udp::socket target{io, {kHere, 0}}, client{io, {kHere, 0}};
  const auto file = folder.path() / "ready";
  Process proxy{folder.path(),
                "truepose-proxy",
                {"--udp", "127.0.0.1:0=127.0.0.1:" + std::to_string(target.local_endpoint().port()), "--set",
                 R"({"nul_bytes": 2})", "--admin", "0", "--seed", "42", "--ready-file", file}};
  const json::value started = ready(proxy, file);
  ASSERT_TRUE(started.is_object()) << proxy.errors();
  EXPECT_EQ(started.at("seed"), 42);
  const std::string listens{started.at_pointer("/listen/0").as_string()};
  const udp::endpoint listen{kHere,
                             static_cast<std::uint16_t>(std::stoi(listens.substr(listens.find(':') + 1)))};

  std::array<char, 16> buffer;
  client.send_to(asio::buffer("abc", 3), listen);
  EXPECT_EQ(target.receive(asio::buffer(buffer)), 5);

  tcp::socket admin{io};
  admin.connect({kHere, started.at("admin").to_number<std::uint16_t>()});
  std::string received;
  const auto ask = [&](const std::string& line) {
    asio::write(admin, asio::buffer(line + "\n"));
    const std::size_t size = asio::read_until(admin, asio::dynamic_buffer(received), '\n');
    const json::value reply = json::parse(received.substr(0, size));
    received.erase(0, size);
    return reply;
  };
  EXPECT_EQ(ask(R"({"clear": true})").at("ok"), true);
  client.send_to(asio::buffer("abc", 3), listen);
  EXPECT_EQ(target.receive(asio::buffer(buffer)), 3);
  EXPECT_EQ(ask(R"({"statistics": true})").at_pointer("/routes/0/to_target/forwarded"), 2);
  EXPECT_TRUE(ask(R"({"losss": 1})").as_object().contains("error"));

  proxy.terminate();
  EXPECT_EQ(proxy.wait(), 0);
  const std::string out = proxy.output();
  EXPECT_EQ(json::parse(out.substr(out.find('\n') + 1)).at_pointer("/routes/0/to_target/received"), 2);
}

TEST(TheProxyProgram, SaysInOneLineWhatItCannotUse) {
  const auto refused = [](const std::vector<std::string>& arguments, int exit_code) {
    const Finished finished = run_program("truepose-proxy", arguments);
    EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
    EXPECT_EQ(std::ranges::count(finished.err, '\n'), 1) << finished.err;
    return finished.err;
  };
  EXPECT_THAT(refused({}, 2), HasSubstr("--udp or --tcp is required"));
  EXPECT_THAT(refused({"--udp", "here"}, 2), HasSubstr("LISTEN=TARGET"));
  EXPECT_THAT(refused({"--udp", "127.0.0.1:0=127.0.0.1:9", "--set", "{\"loss\": 7}"}, 2), HasSubstr("loss"));
  EXPECT_THAT(refused({"--timeline", "/no/such/file"}, 2), HasSubstr("/no/such/file"));
  EXPECT_THAT(refused({"--tcp", "192.0.2.1:0=127.0.0.1:9"}, 3), HasSubstr("192.0.2.1"));
}

}  // namespace
}  // namespace truepose
