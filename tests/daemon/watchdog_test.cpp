#include "daemon/service/watchdog.hpp"

#include <gtest/gtest.h>

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;

const drivers::TimePoint t0{1h};

class WatchdogTest : public testing::Test {
 protected:
  Pulse realtime_{}, compute_{.idle = true};
  Watchdog watchdog_{
      {{"RSI", 2s, [this] { return realtime_; }}, {"compute", 30s, [this] { return compute_; }}}, t0};
};

TEST_F(WatchdogTest, FindsAThreadThatStandsStillForLongerThanItsPatience) {
  EXPECT_EQ(watchdog_.stuck(t0 + 2s), std::nullopt);
  EXPECT_EQ(watchdog_.stuck(t0 + 2001ms), "RSI");
}

TEST_F(WatchdogTest, IsContentWithAThreadThatAdvances) {
  for (auto time = t0; time < t0 + 1min; time += 2s) {
    EXPECT_EQ(watchdog_.stuck(time), std::nullopt);
    ++realtime_.beats;
  }
}

TEST_F(WatchdogTest, LetsALongJobRunAsLongAsItCountsItsSteps) {
  compute_.idle = false;
  for (auto time = t0; time < t0 + 1h; time += 1s) {
    ++realtime_.beats;
    if ((time - t0) % 29s == 0s) ++compute_.beats;
    ASSERT_EQ(watchdog_.stuck(time), std::nullopt);
  }
}

TEST_F(WatchdogTest, FindsAJobThatCountsNoMoreSteps) {
  compute_.idle = false;
  for (auto time = t0; time <= t0 + 30s; time += 1s) {
    ++realtime_.beats;
    ASSERT_EQ(watchdog_.stuck(time), std::nullopt);
  }
  ++realtime_.beats;
  EXPECT_EQ(watchdog_.stuck(t0 + 31s), "compute");
}

TEST_F(WatchdogTest, GivesAJobItsWholePatienceHoweverLongTheThreadWasIdleBefore) {
  for (auto time = t0; time <= t0 + 1h; time += 1s) {
    ++realtime_.beats;
    ASSERT_EQ(watchdog_.stuck(time), std::nullopt);
  }
  compute_.idle = false;
  for (auto time = t0 + 1h; time <= t0 + 1h + 30s; time += 1s) {
    ++realtime_.beats;
    ASSERT_EQ(watchdog_.stuck(time), std::nullopt);
  }
}

TEST_F(WatchdogTest, IsContentAgainWhenTheThreadGoesOn) {
  EXPECT_EQ(watchdog_.stuck(t0 + 3s), "RSI");
  ++realtime_.beats;
  EXPECT_EQ(watchdog_.stuck(t0 + 4s), std::nullopt);
}

}  // namespace
}  // namespace truepose::daemon
