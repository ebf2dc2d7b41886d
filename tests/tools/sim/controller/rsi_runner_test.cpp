#include "tools/sim/controller/rsi_runner.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "proto/rsi/frame_codec.hpp"
#include "tests/simulator_process.hpp"
#include "tests/tools/sim/kr210.hpp"

namespace truepose::sim {
namespace {

using boost::asio::ip::udp;
using config::ScenarioFault;
using Kind = ScenarioFault::Kind;
using namespace std::chrono_literals;

constexpr std::uint64_t kWireIpoc = 5000;
const JointVector kWireHome = deg(0, -90, 90, 0, 35, 0);

ScenarioFault fault(Kind kind, std::int64_t at_cycle, std::int64_t lasts_cycles) {
  return {.kind = kind, .unit = ScenarioFault::Unit::Cycles, .at = at_cycle, .lasts = lasts_cycles};
}

struct Heard {
  std::uint64_t ipoc;
  udp::endpoint from;
};

/// A controller with a cycle of 1 ms, whose time stamps count its cycles, and the PC that it sends to.
class Wire : public testing::Test {
 protected:
  Wire() {
    const timeval minute{.tv_sec = 60, .tv_usec = 0};  // fails a test that nothing comes for
    setsockopt(pc_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &minute, sizeof minute);
  }

  void start(std::vector<ScenarioFault> faults) {
    const auto ethernet =
        rsi::parse_ethernet_config(text_of(TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml"));
    const RsiSetup setup{
        .nominal = kr210(),
        .ethernet = ethernet.value(),
        .context = rsi::truepose_context({.timeout_cycles = std::numeric_limits<int>::max()}),
        .cycle = 1ms};
    runner_ = start_rsi_runner(
        {.host = "127.0.0.1", .port = pc_.local_endpoint().port(), .cycle = 1ms, .faults = std::move(faults)},
        RsiClient{setup, std::make_shared<StreamPath>(kr210(), std::vector{kWireHome}, 1), kWireIpoc},
        {.ended = [](RsiEnd) {}});
  }

  Heard hear() {
    Heard heard;
    const std::size_t size = pc_.receive_from(boost::asio::buffer(buffer_), heard.from);
    heard.ipoc = rsi::decode_robot_frame({buffer_.data(), size}).value().ipoc;
    return heard;
  }

  std::string hear_bytes() {
    udp::endpoint from;
    return {buffer_.data(), pc_.receive_from(boost::asio::buffer(buffer_), from)};
  }

  std::vector<std::uint64_t> ipocs(std::size_t count) {
    std::vector<std::uint64_t> heard(count);
    std::ranges::generate(heard, [this] { return hear().ipoc - kWireIpoc + 1; });
    return heard;
  }

  using Numbers = std::vector<std::uint64_t>;

  boost::asio::io_context context_;
  udp::socket pc_{context_, {boost::asio::ip::address_v4::loopback(), 0}};
  std::array<char, 65536> buffer_{};
  std::unique_ptr<RsiSession> runner_;
};

TEST_F(Wire, LosesDatagramsAndReachesThePcAgain) {
  start({fault(Kind::RsiLoseDatagrams, 3, 4), fault(Kind::RsiDrop, 9, 2)});
  EXPECT_EQ(ipocs(7), (Numbers{1, 2, 7, 8, 11, 12, 13}));
}

TEST_F(Wire, LosesRepliesFromTheCycleOnInWhichTheScenarioSaysSo) {
  start({fault(Kind::RsiLoseReplies, 2, 1000)});
  const rsi::SensorFrameCodec codec{
      rsi::parse_ethernet_config(text_of(TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml"))
          .value()};
  std::array<char, rsi::kMaxFrameBytes> reply;
  for (int cycle = 1; cycle <= 21; ++cycle) {
    const Heard heard = hear();
    pc_.send_to(boost::asio::buffer(codec.encode({.ipoc = heard.ipoc}, reply).value()), heard.from);
  }
  runner_->stop();
  const RsiCounters counters = runner_->statistics().counters;
  // Whether the first was answered in time is up to the machine.
  EXPECT_LE(counters.answered + counters.late, 1u);
  EXPECT_GE(counters.lost, 20u);
}

TEST_F(Wire, SendsDatagramsTwiceAndInAnotherOrder) {
  start({fault(Kind::RsiDuplicate, 2, 2), fault(Kind::RsiReorder, 6, 4)});
  EXPECT_EQ(ipocs(12), (Numbers{1, 2, 2, 3, 3, 4, 5, 7, 6, 9, 8, 10}));
}

TEST_F(Wire, SendsDatagramsACycleLateInTheirOrder) {
  start({fault(Kind::RsiLate, 3, 2)});
  EXPECT_EQ(ipocs(6), (Numbers{1, 2, 3, 4, 5, 6}));
  runner_->stop();
}

TEST_F(Wire, CorruptsAByteOfEachDatagram) {
  start({fault(Kind::RsiCorrupt, 2, 3)});
  const std::string first = hear_bytes();
  for (int cycle = 2; cycle < 5; ++cycle) {
    const std::string garbled = hear_bytes();
    EXPECT_EQ(std::ranges::count(garbled, '<'), std::ranges::count(first, '<') + 1);
  }
  EXPECT_EQ(ipocs(1), Numbers{5});
}

TEST_F(Wire, IsSilentWhileItsClockGoesOn) {
  start({fault(Kind::RsiSilence, 4, 50)});
  EXPECT_EQ(ipocs(5), (Numbers{1, 2, 3, 54, 55}));
}

TEST_F(Wire, IsSilentToItsEndWhereItIsStoppedMeanwhile) {
  start({fault(Kind::RsiSilence, 3, 100'000)});
  EXPECT_EQ(ipocs(2), (Numbers{1, 2}));
  runner_->stop();
  EXPECT_EQ(pc_.available(), 0u);
}

TEST_F(Wire, SwitchesRsiOffAndOnAndThenSendsFromAnotherPort) {
  ScenarioFault at_zero = fault(Kind::RsiRestart, 6, 2);
  at_zero.ipoc = kWireIpoc + 1000;
  start({fault(Kind::RsiRestart, 3, 10), at_zero});
  std::vector<Heard> heard(6);
  std::ranges::generate(heard, [this] { return hear(); });
  Numbers numbers;
  std::set<std::uint16_t> ports;
  for (const Heard& datagram : heard) {
    numbers.push_back(datagram.ipoc - kWireIpoc + 1);
    ports.insert(datagram.from.port());
  }
  EXPECT_EQ(numbers, (Numbers{1, 2, 13, 14, 15, 1001}));
  EXPECT_EQ(ports.size(), 3u);
  runner_->stop();
  EXPECT_EQ(runner_->statistics().sessions, 3u);
}

TEST_F(Wire, LetsItsTimeStampJump) {
  ScenarioFault jump = fault(Kind::RsiIpoc, 3, 0);
  jump.ipoc_by = -2;
  start({jump});
  EXPECT_EQ(ipocs(4), (Numbers{1, 2, 1, 2}));
}

TEST_F(Wire, HasASecondControllerThatCountsForItself) {
  ScenarioFault second = fault(Kind::RsiSecondSender, 3, 0);
  second.from = "127.0.0.2";
  start({second});
  const auto hear_stranger = [this] {
    for (;;) {
      if (const Heard heard = hear(); heard.from.address().to_string() == "127.0.0.2") return heard;
    }
  };
  const Heard stranger = hear_stranger();
  EXPECT_GT(stranger.ipoc, kWireIpoc + 1'000'000);
  const rsi::SensorFrameCodec codec{
      rsi::parse_ethernet_config(text_of(TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml"))
          .value()};
  std::array<char, rsi::kMaxFrameBytes> reply;
  const rsi::Axes correction{0.01};
  pc_.send_to(boost::asio::buffer(
                  codec.encode({.ipoc = stranger.ipoc, .axis_correction_rad = correction}, reply).value()),
              stranger.from);
  hear_stranger();  // so that its first cycle is over, and counted
  runner_->stop();
  const RsiStatistics statistics = runner_->statistics();
  EXPECT_GE(statistics.second_senders.cycles, 1u);
  EXPECT_EQ(statistics.counters.wrong_ipoc, 0u) << "its replies go to itself";
  EXPECT_EQ(statistics.counters.max_step_rad, 0) << "and move nothing of ours";
}

TEST_F(Wire, CanBeDisturbedWhileItRuns) {
  start({});
  std::uint64_t before = 0, after = hear().ipoc;
  runner_->disturb(fault(Kind::RsiSilence, 0, 1000));
  do {
    before = std::exchange(after, hear().ipoc);
  } while (after == before + 1);
  EXPECT_EQ(after, before + 1001);
}

TEST(TurnaroundHistogram, KnowsItsPercentilesAndItsSlowest) {
  TurnaroundHistogram histogram;
  EXPECT_EQ(histogram.percentile_us(0.99), 0);
  for (int us = 1; us <= 1000; ++us) histogram.record(std::chrono::microseconds{us});
  histogram.record(3s);
  EXPECT_EQ(histogram.percentile_us(0.5), 501);
  EXPECT_EQ(histogram.percentile_us(0.999), 1000);
  EXPECT_EQ(histogram.percentile_us(1.0), 3'000'000);
  EXPECT_EQ(histogram.max_us(), 3'000'000);
}

}  // namespace
}  // namespace truepose::sim
