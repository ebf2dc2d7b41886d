// truepose listen as its users start it, with a controller that is scripted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/json/parse.hpp>

#include "tests/process.hpp"
#include "tests/tools/doctor/scripted_controller.hpp"

namespace truepose {
namespace {

namespace asio = boost::asio;
namespace json = boost::json;
using asio::ip::udp;
using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kEthernet = TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml";

std::uint16_t unused_udp_port() {
  asio::io_context io;
  return udp::socket{io, {asio::ip::address_v4::loopback(), 0}}.local_endpoint().port();
}

/// As the shipped configuration has it.
std::string good_frame(std::uint64_t cycle) {
  const std::string axes =
      " A1=\"0.0000\" A2=\"-90.0000\" A3=\"90.0000\" A4=\"0.0000\" A5=\"0.0000\" A6=\"0.0000\"/>";
  const std::string pose = " X=\"1.0000\" Y=\"0.0000\" Z=\"0.0000\" A=\"0.0000\" B=\"0.0000\" C=\"0.0000\"/>";
  return "<Rob Type=\"KUKA\"><RIst" + pose + "<RSol" + pose + "<AIPos" + axes + "<ASPos" + axes +
         "<Delay D=\"0\"/><Tp Ask=\"1\" Pro=\"3\" Mode=\"4\" Ov=\"100\" Cell=\"1024\"/><IPOC>" +
         std::to_string(4 * cycle) + "</IPOC></Rob>";
}

/// Listens to a port while a sender sends there.
Finished listen_while(const ScriptedController::Frame& frame, std::vector<std::string> options) {
  const std::uint16_t port = unused_udp_port();
  const ScriptedController sender{port, frame};
  options.insert(options.begin(), {"listen", "127.0.0.1:" + std::to_string(port)});
  return run_program("truepose", options);
}

TEST(Listen, TellsWhatAControllerSends) {
  const Finished heard = listen_while(good_frame, {"--frames", "20", "--ethernet", kEthernet});
  EXPECT_EQ(heard.exit_code, 0) << heard.out << heard.err;
  EXPECT_THAT(heard.out, AllOf(HasSubstr("127.0.0.1:"), HasSubstr("IPOC + 4"), HasSubstr("AIPos.A1"),
                               HasSubstr("decimals   4"), HasSubstr("missing    -")));
}

TEST(Listen, PrintsOneDocument) {
  const Finished heard = listen_while(good_frame, {"--frames", "20", "--ethernet", kEthernet, "--json"});
  const json::value report = json::parse(heard.out);
  EXPECT_EQ(report.at("good"), true);
  EXPECT_GE(report.at_pointer("/senders/0/frames").to_number<int>(), 20);
  EXPECT_EQ(report.at_pointer("/senders/0/ipoc_step"), 4);
}

TEST(Listen, SaysThatNobodySends) {
  const Finished heard =
      run_program("truepose", {"listen", "127.0.0.1:" + std::to_string(unused_udp_port()), "--for", "0"});
  EXPECT_EQ(heard.exit_code, 1);
  EXPECT_THAT(heard.out, HasSubstr("no packet came to"));
}

TEST(Listen, NamesWhoHoldsThePort) {
  asio::io_context io;
  const udp::socket holder{io, {asio::ip::address_v4::loopback(), 0}};
  const std::string port = std::to_string(holder.local_endpoint().port());
  const Finished refused = run_program("truepose", {"listen", "127.0.0.1:" + port});
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_THAT(refused.err, AllOf(HasSubstr(port), HasSubstr("(process " + std::to_string(getpid()) + ")")));
}

}  // namespace
}  // namespace truepose
