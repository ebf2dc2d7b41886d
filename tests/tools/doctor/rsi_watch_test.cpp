#include "tools/truepose/doctor/rsi_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/truepose/doctor/rsi_report.hpp"

namespace truepose::tools {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::SizeIs;

constexpr drivers::UdpSource kOne{0x7f000001, 50000}, kOther{0x7f000002, 50000};

class AnRsiWatch : public testing::Test {
 protected:
  void take(const std::string& bytes, drivers::UdpSource source = kOne) {
    watch.take({.bytes = bytes, .source = source, .received = now}, false);
  }
  void frame(std::uint64_t ipoc, int delay = 0, drivers::UdpSource source = kOne) {
    take("<Rob Type=\"KUKA\"><AIPos A1=\"1.25\" A2=\"0\" A3=\"0\" A4=\"0\" A5=\"0\" A6=\"0\"/><Delay D=\"" +
             std::to_string(delay) + "\"/><IPOC>" + std::to_string(ipoc) + "</IPOC></Rob>",
         source);
  }

  RsiWatch watch;
  drivers::TimePoint now{};
};

TEST_F(AnRsiWatch, TellsTheCycleByIpocAndByArrival) {
  for (std::uint64_t i = 0; i < 5; ++i, now += 12ms) frame(1000 + 4 * i + (i > 2 ? 4 : 0));
  const RsiSender sender = watch.senders().at(0);
  EXPECT_EQ(sender.frames, 5);
  EXPECT_EQ(sender.ipoc_step, 4);
  EXPECT_EQ(sender.ipoc, 1020);
  EXPECT_DOUBLE_EQ(sender.cycle_ms().value(), 12);
  EXPECT_EQ(sender.longest, 12ms);
}

TEST_F(AnRsiWatch, TellsWhetherDelayRises) {
  frame(4, 7);
  frame(8, 7);
  EXPECT_FALSE(watch.senders().at(0).delay_rises());
  frame(12, 8);
  EXPECT_TRUE(watch.senders().at(0).delay_rises());
}

TEST_F(AnRsiWatch, KeepsSendersApart) {
  frame(4);
  frame(4, 0, kOther);
  EXPECT_THAT(watch.senders(), SizeIs(2));
  EXPECT_EQ(watch.frames(), 2);
}

TEST_F(AnRsiWatch, TellsNoMoreThan32SendersOfAFlood) {
  for (std::uint16_t port = 1; port <= 100; ++port) frame(4, 0, {1, port});
  EXPECT_THAT(watch.senders(), SizeIs(32));
}

TEST_F(AnRsiWatch, SaysWhyAFrameIsMalformedAtWhichByteAndHowItLooks) {
  take("<Rob><AIPos A1=\"1\"/><IPOC>4</IPOC></Rob>");
  const RsiSender sender = watch.senders().at(0);
  EXPECT_EQ(sender.malformed, 1);
  EXPECT_THAT(sender.why_malformed, HasSubstr("AIPos.A2 is missing (at byte"));
  EXPECT_THAT(sender.why_malformed, HasSubstr("<AIPos A1="));
}

TEST_F(AnRsiWatch, ComparesWhatComesWithTheConfiguration) {
  frame(4);
  rsi::EthernetConfig ethernet;
  ethernet.send = {{.tag = "DEF_AIPos"}, {.tag = "DEF_Delay"}};
  EXPECT_TRUE(is_of_kind(watch.senders().at(0), ethernet));
  ethernet.send = {{.tag = "DEF_AIPos"}, {.tag = "DEF_RIst"}};
  EXPECT_FALSE(is_of_kind(watch.senders().at(0), ethernet));
  const SenderReport report = sender_report(watch.senders().at(0), ethernet);
  EXPECT_EQ(report.unknown, std::vector<std::string>{"Delay"});
  EXPECT_EQ(report.missing, std::vector<std::string>{"DEF_RIst"});
  EXPECT_EQ(report.decimals, 2);
}

}  // namespace
}  // namespace truepose::tools
