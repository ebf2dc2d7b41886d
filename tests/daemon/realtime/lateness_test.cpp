#include "daemon/realtime/lateness.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;
using drivers::Duration;
using drivers::TimePoint;

constexpr Duration kCycle = 4ms;

/// A thread that answers a controller's datagrams one after the other.
class LatenessTest : public testing::Test {
 protected:
  struct Delays {
    Duration network{0}, woken{50us}, computed{20us}, kept_from_running{0}, sending{10us};
  };
  std::optional<LateBy> cycle(const Delays& delays, std::uint64_t elapsed = 1) {
    due_ += kCycle * static_cast<Duration::rep>(elapsed);
    const TimePoint received = due_ + delays.network;
    const TimePoint taken = std::max(received, free_) + delays.woken;
    const TimePoint ready = taken + delays.computed + delays.kept_from_running;
    free_ = ready + delays.sending;
    lateness_.heard(received, elapsed);
    return lateness_.judge({received, taken, ready, free_, delays.computed, true});
  }

  Lateness lateness_{kCycle};
  TimePoint due_{}, free_{};
};

TEST_F(LatenessTest, SaysNothingOfAReplyThatLeavesWithinHalfACycle) {
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(cycle({.network = i % 7 * 100us, .woken = i % 5 * 200us}), std::nullopt);
  EXPECT_EQ(cycle({.network = 600us, .woken = 600us, .computed = 600us}), std::nullopt);
}

TEST_F(LatenessTest, NamesWhoseDelayIsTheGreatest) {
  cycle({});
  EXPECT_EQ(cycle({.network = 1900us, .woken = 300us}), LateBy::Network);
  EXPECT_EQ(cycle({.network = 300us, .woken = 1900us}), LateBy::Machine);
  EXPECT_EQ(cycle({.computed = 1990us}), LateBy::Daemon);
  EXPECT_EQ(cycle({.sending = 1990us}), LateBy::Machine);
}

TEST_F(LatenessTest, PutsTheTimeInWhichTheThreadDidNotRunDownToTheMachine) {
  cycle({});
  EXPECT_EQ(cycle({.kept_from_running = 3ms}), LateBy::Machine);
}

TEST_F(LatenessTest, PutsWhatWaitedForACycleDownToWhoHeldThatUp) {
  cycle({});
  EXPECT_EQ(cycle({.computed = 11ms}), LateBy::Daemon);
  EXPECT_EQ(cycle({}), LateBy::Daemon);
  EXPECT_EQ(cycle({}), LateBy::Daemon);
  EXPECT_EQ(cycle({}), std::nullopt);
  EXPECT_EQ(cycle({.woken = 11ms}), LateBy::Machine);
  EXPECT_EQ(cycle({}), LateBy::Machine);
}

TEST_F(LatenessTest, CountsLostDatagramsInThePace) {
  cycle({});
  EXPECT_EQ(cycle({}, 5), std::nullopt);
  EXPECT_EQ(cycle({.network = 2100us}, 5), LateBy::Network);
}

TEST_F(LatenessTest, FollowsAControllerWhoseClockIsSlowOrFast) {
  for (const Duration drift : {-3us, 3us}) {
    lateness_.restart();
    for (int i = 0; i < 10'000; ++i) {
      due_ += drift;
      ASSERT_EQ(cycle({}), std::nullopt) << i;
    }
    EXPECT_EQ(cycle({.network = 2100us}), LateBy::Network);
  }
}

TEST_F(LatenessTest, TakesALongerWayAsTheUsualOneAfterATenthOfASecond) {
  cycle({});
  const auto late = [&](Duration longer) {
    int cycles = 0;
    for (int i = 0; i < 1000; ++i) cycles += cycle({.network = longer + i % 3 * 100us}) == LateBy::Network;
    return cycles;
  };
  EXPECT_EQ(late(100ms), 25);
  EXPECT_EQ(late(3ms), 0) << "a shorter way is taken at once";
  EXPECT_EQ(late(7ms), 25);
}

TEST_F(LatenessTest, CountsDelaysThatComeAndGoHoweverLongThatLasts) {
  cycle({});
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(cycle({.network = 3ms}), LateBy::Network);
    EXPECT_EQ(cycle({}), std::nullopt);
  }
}

TEST_F(LatenessTest, BeginsAPaceOfItsOwnWithEachSession) {
  cycle({});
  due_ += 1s;
  lateness_.restart();
  EXPECT_EQ(cycle({}), std::nullopt);
}

}  // namespace
}  // namespace truepose::daemon
