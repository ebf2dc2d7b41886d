#include "daemon/cell/last_minute.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;

StreamCounters counted(std::uint64_t answered, std::uint64_t late_by_network) {
  StreamCounters counters;
  counters.answered = answered;
  counters.late_by_network = late_by_network;
  return counters;
}

TEST(LastMinute, CountsWhatCameSinceAMinuteAgo) {
  LastMinute minute;
  const drivers::TimePoint start{1h};
  EXPECT_EQ(minute.of(counted(5, 5)).replies(), 0u) << "nothing is known yet";
  // 250 replies a second, all of them late in the first two minutes.
  for (int tenths = 0; tenths <= 1500; ++tenths) {
    const auto answered = static_cast<std::uint64_t>(25 * tenths);
    minute.take(counted(answered, std::min<std::uint64_t>(answered, 30'000)), start + tenths * 100ms);
  }
  const StreamCounters last = minute.of(counted(37'500, 30'000));
  EXPECT_NEAR(static_cast<double>(last.replies()), 15'000, 250);
  EXPECT_NEAR(static_cast<double>(last.late_by_network), 7'500, 250);
}

}  // namespace
}  // namespace truepose::daemon
