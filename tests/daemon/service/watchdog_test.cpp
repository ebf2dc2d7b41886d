#include <gtest/gtest.h>

#include "daemon/service/service_manager.hpp"

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;

const drivers::TimePoint kStart{1h};

class WatchdogTest : public testing::Test {
 protected:
  Pulse realtime_{}, compute_{.idle = true};
  Watchdog watchdog_{
      {{"RSI", 2s, [this] { return realtime_; }}, {"compute", 30s, [this] { return compute_; }}}, kStart};
};

TEST_F(WatchdogTest, FindsAThreadThatStandsStillForLongerThanItsPatience) {
  EXPECT_EQ(watchdog_.stuck(kStart + 2s), std::nullopt);
  EXPECT_EQ(watchdog_.stuck(kStart + 2001ms), "RSI");
}

TEST_F(WatchdogTest, IsContentWithAThreadThatAdvances) {
  for (auto time = kStart; time < kStart + 1min; time += 2s) {
    EXPECT_EQ(watchdog_.stuck(time), std::nullopt);
    ++realtime_.beats;
  }
}

TEST_F(WatchdogTest, LetsALongJobRunAsLongAsItCountsItsSteps) {
  compute_.idle = false;
  for (auto time = kStart; time < kStart + 1h; time += 1s) {
    ++realtime_.beats;
    if ((time - kStart) % 29s == 0s) ++compute_.beats;
    ASSERT_EQ(watchdog_.stuck(time), std::nullopt);
  }
}

TEST_F(WatchdogTest, FindsAJobThatCountsNoMoreSteps) {
  compute_.idle = false;
  for (auto time = kStart; time <= kStart + 30s; time += 1s) {
    ++realtime_.beats;
    ASSERT_EQ(watchdog_.stuck(time), std::nullopt);
  }
  ++realtime_.beats;
  EXPECT_EQ(watchdog_.stuck(kStart + 31s), "compute");
}

TEST_F(WatchdogTest, GivesAJobItsWholePatienceHoweverLongTheThreadWasIdleBefore) {
  for (auto time = kStart; time <= kStart + 1h; time += 1s) {
    ++realtime_.beats;
    ASSERT_EQ(watchdog_.stuck(time), std::nullopt);
  }
  compute_.idle = false;
  for (auto time = kStart + 1h; time <= kStart + 1h + 30s; time += 1s) {
    ++realtime_.beats;
    ASSERT_EQ(watchdog_.stuck(time), std::nullopt);
  }
}

TEST_F(WatchdogTest, SaysOfEachThreadWhatItDoes) {
  const auto seen = watchdog_.look(kStart + 3s);
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].name, "RSI");
  EXPECT_EQ(seen[0].still_for, 3s);
  EXPECT_TRUE(seen[0].stuck);
  EXPECT_TRUE(seen[1].idle);
  EXPECT_FALSE(seen[1].stuck);
}

TEST_F(WatchdogTest, IsContentAgainWhenTheThreadGoesOn) {
  EXPECT_EQ(watchdog_.stuck(kStart + 3s), "RSI");
  ++realtime_.beats;
  EXPECT_EQ(watchdog_.stuck(kStart + 4s), std::nullopt);
}

}  // namespace
}  // namespace truepose::daemon
