#include "tools/sim/controller/rsi_exchange.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/rsi/frame_codec.hpp"
#include "tests/simulator_process.hpp"
#include "tests/tools/sim/kr210.hpp"

namespace truepose::sim {
namespace {

using namespace std::chrono_literals;

/// A controller with a cycle of 4 ms and a PC that answers each datagram, in virtual time.
class ExchangeInVirtualTime : public testing::Test, public RsiWire {
 protected:
  using Kind = config::ScenarioFault::Kind;
  using Time = RsiExchange::Time;
  /// Numbered by the cycle of its time stamp, from 1.
  struct Sent {
    std::int64_t at_ms;
    std::uint64_t number;
    bool operator==(const Sent&) const = default;
  };
  struct Reply {
    Time at;
    std::string bytes;
  };

  static config::ScenarioFault fault(Kind kind, std::int64_t at, std::int64_t lasts, std::int64_t every = 0) {
    return {
        .kind = kind, .unit = config::ScenarioFault::Unit::Cycles, .at = at, .lasts = lasts, .every = every};
  }

  void start(std::vector<config::ScenarioFault> faults,
             int timeout_cycles = std::numeric_limits<int>::max()) {
    const RsiSetup setup{.nominal = kr210(),
                         .ethernet = ethernet_,
                         .context = rsi::truepose_context({.timeout_cycles = timeout_cycles}),
                         .cycle = 4ms};
    const std::vector home{deg(0, -90, 90, 0, 35, 0)};
    exchange_.emplace(*this, RsiClient{setup, std::make_shared<StreamPath>(kr210(), home, 1), kFirst}, 4ms,
                      std::move(faults), 0);
    exchange_->begin_at(now_);
  }

  void run(int cycles) {
    for (; cycles > 0 && !exchange_->end(); --cycles) {
      while (exchange_->begin_faults()) {
        while (exchange_->begin_silent_cycle()) {
          now_ = exchange_->tick();
          exchange_->end_silent_cycle();
        }
      }
      ASSERT_TRUE(exchange_->begin_cycle());
      exchange_->send(now_);
      for (; !replies_.empty() && replies_.front().at <= exchange_->tick(); replies_.pop_front()) {
        const auto turnaround = exchange_->receive(replies_.front().bytes, replies_.front().at);
        if (turnaround) ++turnarounds_[*turnaround];
      }
      now_ = exchange_->tick();
      exchange_->end_cycle();
    }
  }

  void send(std::string_view datagram) override {
    const std::uint64_t ipoc = rsi::decode_robot_frame(datagram).value().ipoc;
    sent_.push_back({(now_ - Time{}) / 1ms, (ipoc - kFirst) / 4 + 1});
    std::array<char, rsi::kMaxFrameBytes> reply;
    replies_.push_back({now_ + answers_after_, std::string{codec_.encode({.ipoc = ipoc}, reply).value()}});
  }
  void restarted() override { ++restarts_; }
  void begin_second_sender(RsiClient twin, const std::string& from) override {
    second_senders_.emplace_back(from, twin.ipoc());
  }

  static constexpr std::uint64_t kFirst = 5000;
  const rsi::EthernetConfig ethernet_ =
      rsi::parse_ethernet_config(text_of(TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml"))
          .value();
  const rsi::SensorFrameCodec codec_{ethernet_};
  Time now_;
  std::chrono::nanoseconds answers_after_ = 1ms;
  std::deque<Reply> replies_;
  std::vector<Sent> sent_;
  std::map<std::chrono::nanoseconds, int> turnarounds_;
  int restarts_ = 0;
  std::vector<std::pair<std::string, std::uint64_t>> second_senders_;
  std::optional<RsiExchange> exchange_;
};

TEST_F(ExchangeInVirtualTime, LosesDelaysAndReordersDatagramsByTheNumberOfTheCycle) {
  constexpr int kHundreds = 100;
  start({fault(Kind::RsiDrop, 10, 2, 100), fault(Kind::RsiLate, 50, 1, 100),
         fault(Kind::RsiReorder, 70, 2, 100)});
  run(kHundreds * 100);

  std::vector<Sent> expected;
  for (std::uint64_t cycle = 1; cycle <= kHundreds * 100; ++cycle) {
    const std::int64_t at_ms = 4 * (static_cast<std::int64_t>(cycle) - 1);
    const std::uint64_t of_hundred = cycle % 100;
    if (of_hundred == 10 || of_hundred == 11 || of_hundred == 50 || of_hundred == 70) continue;
    if (of_hundred == 51) expected.push_back({at_ms, cycle - 1});
    expected.push_back({at_ms, cycle});
    if (of_hundred == 71) expected.push_back({at_ms, cycle - 1});
  }
  EXPECT_EQ(sent_.size(), expected.size());
  EXPECT_TRUE(sent_ == expected);
  const RsiCounters& counters = exchange_->client().counters();
  EXPECT_EQ(counters.cycles, kHundreds * 100u);
  EXPECT_EQ(counters.answered, kHundreds * 96u);
  EXPECT_EQ(counters.late, kHundreds * 2u) << "one datagram was delayed, one came after the next";
  EXPECT_EQ(counters.lost, kHundreds * 2u);
  EXPECT_EQ(counters.wrong_ipoc, 0u);
  EXPECT_EQ(turnarounds_,
            (std::map<std::chrono::nanoseconds, int>{{1ms, kHundreds * 96}, {5ms, kHundreds * 2}}));
}

TEST_F(ExchangeInVirtualTime, PausesForWholeCyclesAndKeepsItsTicks) {
  start({fault(Kind::RsiSilence, 3, 50), fault(Kind::RsiRestart, 5, 10)});
  run(6);
  EXPECT_EQ(sent_, (std::vector<Sent>{{0, 1}, {4, 2}, {208, 53}, {212, 54}, {256, 65}, {260, 66}}));
  EXPECT_EQ(restarts_, 1);
  EXPECT_EQ(exchange_->client().counters().answered, 6u);
}

TEST_F(ExchangeInVirtualTime, ForgetsADelayedDatagramWhereRsiIsRestarted) {
  start({fault(Kind::RsiLate, 2, 1), fault(Kind::RsiRestart, 3, 1)});
  run(3);
  EXPECT_EQ(sent_, (std::vector<Sent>{{0, 1}, {12, 4}}));
}

TEST_F(ExchangeInVirtualTime, BeginsTheNextFaultOfACycleAfterThePauseOfTheOneBefore) {
  config::ScenarioFault jump = fault(Kind::RsiIpoc, 2, 0);
  jump.ipoc_by = 4000;
  start({fault(Kind::RsiSilence, 2, 5), fault(Kind::RsiSilence, 2, 10), jump});
  run(2);
  EXPECT_EQ(sent_, (std::vector<Sent>{{0, 1}, {64, 1017}}));
}

TEST_F(ExchangeInVirtualTime, EndsWithATimeoutInTheCycleThatLacksOneReplyTooMany) {
  start({fault(Kind::RsiLoseReplies, 21, 0)}, 10);
  run(1000);
  EXPECT_EQ(exchange_->end(), RsiEnd::Timeout);
  EXPECT_EQ(now_, Time{30 * 4ms});
  EXPECT_EQ(sent_.size(), 30u) << "its datagrams are not lost";
}

TEST_F(ExchangeInVirtualTime, MeasuresTheTimeToAReplyThatComesCyclesLater) {
  answers_after_ = 9ms;
  start({});
  run(10);
  EXPECT_EQ(turnarounds_, (std::map<std::chrono::nanoseconds, int>{{9ms, 8}}));
  EXPECT_EQ(exchange_->client().counters().late, 8u);
  EXPECT_EQ(exchange_->client().counters().lost, 2u)
      << "of the last two cycles, whose replies are still on their way";
}

TEST_F(ExchangeInVirtualTime, BeginsADisturbanceWithTheComingCycle) {
  start({});
  run(3);
  exchange_->disturb(fault(Kind::RsiLoseDatagrams, 0, 2));
  run(4);
  EXPECT_EQ(sent_, (std::vector<Sent>{{0, 1}, {4, 2}, {8, 3}, {20, 6}, {24, 7}}));
}

TEST_F(ExchangeInVirtualTime, LetsASecondSenderBeginOnceAndCoversItsCycles) {
  config::ScenarioFault second = fault(Kind::RsiSecondSender, 3, 2);
  second.from = "127.0.0.2";
  start({second});
  std::vector<int> covered;
  for (int cycle = 1; cycle <= 6; ++cycle) {
    run(1);
    if (exchange_->covers(Kind::RsiSecondSender)) covered.push_back(cycle);
  }
  EXPECT_EQ(covered, (std::vector{3, 4}));
  ASSERT_EQ(second_senders_.size(), 1u);
  EXPECT_EQ(second_senders_.front().first, "127.0.0.2");
  EXPECT_GT(second_senders_.front().second, kFirst + 1'000'000) << "its clock is another one";
}

}  // namespace
}  // namespace truepose::sim
