#include "drivers/kuka/rsi_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <string>

namespace truepose::drivers {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using testing::HasSubstr;

/// Answers with what it got, and with nothing to "quiet".
class Echo final : public RsiResponder {
 public:
  std::string_view answer(const Datagram& datagram) noexcept override {
    return datagram.bytes == "quiet" ? std::string_view{} : datagram.bytes;
  }
};

/// The controller's side.
class Controller {
 public:
  explicit Controller(std::uint16_t port) : link_{asio::ip::address_v4::loopback(), port} {}

  void send(const std::string& text) { socket_.send_to(asio::buffer(text), link_); }

  std::string receive() {
    static std::array<char, 65536> bytes;
    udp::endpoint from;
    const std::size_t size = socket_.receive_from(asio::buffer(bytes), from);
    EXPECT_EQ(from, link_);
    return {bytes.data(), size};
  }

 private:
  asio::io_context context_;
  udp::endpoint link_;
  udp::socket socket_{context_, udp::endpoint{asio::ip::address_v4::loopback(), 0}};
};

RsiLinkOptions loopback(std::uint16_t port = 0) {
  return {.address = "127.0.0.1", .port = port, .priority = 0, .require_realtime = false};
}

TEST(RsiLink, AnswersEachDatagramToItsSource) {
  Echo echo;
  const auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  Controller first{(*link)->port()};
  Controller second{(*link)->port()};
  first.send("one");
  second.send("two");
  first.send("three");
  EXPECT_EQ(first.receive(), "one");
  EXPECT_EQ(first.receive(), "three");
  EXPECT_EQ(second.receive(), "two");
  const std::string large(60000, 'x');
  first.send(large);
  EXPECT_EQ(first.receive(), large);
}

TEST(RsiLink, StaysQuietWhereTheResponderDoesAndCounts) {
  Echo echo;
  const auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  Controller controller{(*link)->port()};
  for (const char* text : {"quiet", "a", "b"}) controller.send(text);
  EXPECT_EQ(controller.receive(), "a");
  EXPECT_EQ(controller.receive(), "b");
  const RsiLink::Counters counters = (*link)->counters();
  EXPECT_EQ(counters.received, 3u);
  EXPECT_EQ(counters.unanswered, 1u);
  EXPECT_GE(counters.answered, 1u) << "a reply is counted once it has been sent";
  EXPECT_EQ(counters.truncated + counters.send_failed, 0u);
}

TEST(RsiLink, FreesItsPortWhenItEnds) {
  Echo echo;
  auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  const std::uint16_t port = (*link)->port();
  link->reset();
  EXPECT_TRUE(RsiLink::start(loopback(port), echo));
}

TEST(RsiLink, NamesWhoHoldsThePort) {
  Echo echo;
  const auto link = RsiLink::start(loopback(), echo);
  ASSERT_TRUE(link) << link.error().text;
  const auto second = RsiLink::start(loopback((*link)->port()), echo);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().text, HasSubstr("127.0.0.1:" + std::to_string((*link)->port()) + " is in use by "));
  EXPECT_THAT(second.error().text, HasSubstr("(process " + std::to_string(::getpid()) + ")"));
}

TEST(RsiLink, NamesAnAddressThatIsNotThisMachines) {
  Echo echo;
  RsiLinkOptions options = loopback();
  options.address = "192.0.2.1";
  EXPECT_THAT(RsiLink::start(options, echo).error().text, HasSubstr("192.0.2.1:0 is not one of this machine's"));
  options.address = "controller";
  EXPECT_THAT(RsiLink::start(options, echo).error().text, HasSubstr("not an IPv4 address"));
}

TEST(RsiLink, TellsHowItIsScheduled) {
  Echo echo;
  const auto ordinary = RsiLink::start(loopback(), echo);
  EXPECT_EQ((*ordinary)->scheduling(), "ordinary scheduling");
}

TEST(RsiLink, RefusesToStartWithoutTheRealtimeThatIsRequired) {
  Echo echo;
  RsiLinkOptions options = loopback();
  options.priority = 100;  // above what any machine grants
  options.require_realtime = true;
  const auto link = RsiLink::start(options, echo);
  ASSERT_FALSE(link);
  EXPECT_THAT(link.error().text, HasSubstr("LimitRTPRIO"));
  options.require_realtime = false;
  const auto best_effort = RsiLink::start(options, echo);
  ASSERT_TRUE(best_effort) << best_effort.error().text;
  EXPECT_THAT((*best_effort)->scheduling(), HasSubstr("refused"));
}

}  // namespace
}  // namespace truepose::drivers
