#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <random>
#include <thread>
#include <vector>

#include "daemon/realtime/lock_free.hpp"
#include "tests/daemon/stream_rig.hpp"

namespace truepose::daemon {
namespace {

using Block = std::array<std::uint64_t, 32>;

TEST(SnapshotExchange, GivesTheNewestValueOnce) {
  SnapshotExchange<int> exchange;
  EXPECT_FALSE(exchange.take());
  EXPECT_EQ(exchange.front(), 0);
  for (const int value : {1, 2, 3}) {
    exchange.back() = value;
    exchange.publish();
  }
  EXPECT_TRUE(exchange.take());
  EXPECT_EQ(exchange.front(), 3);
  EXPECT_FALSE(exchange.take());
  EXPECT_EQ(exchange.front(), 3);
}

TEST(SnapshotExchange, NeverTearsOrGoesBackBetweenThreads) {
  constexpr std::uint64_t kLast = 200'000;
  SnapshotExchange<Block> exchange;
  std::thread writer{[&] {
    for (std::uint64_t value = 1; value <= kLast; ++value) {
      exchange.back().fill(value);
      exchange.publish();
    }
  }};
  std::uint64_t last = 0;
  while (last < kLast) {
    if (!exchange.take()) {
      std::this_thread::yield();
      continue;
    }
    const Block& block = exchange.front();
    ASSERT_TRUE(std::all_of(block.begin(), block.end(), [&](std::uint64_t x) { return x == block[0]; }));
    ASSERT_GT(block[0], last);
    last = block[0];
  }
  writer.join();
}

TEST(SpscRing, KeepsTheOrderAndCountsWhatItHasNoRoomFor) {
  SpscRing<int, 4> ring;
  for (int i = 0; i < 6; ++i) EXPECT_EQ(ring.push(i), i < 4);
  EXPECT_EQ(ring.dropped(), 2u);
  int value = -1;
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(ring.pop(value));
    EXPECT_EQ(value, i);
  }
  EXPECT_FALSE(ring.pop(value));
}

TEST(SpscRing, LosesTearsAndReordersNothingBetweenThreads) {
  constexpr std::uint64_t kCount = 200'000;
  SpscRing<Block, 64> ring;
  std::thread writer{[&] {
    for (std::uint64_t value = 0; value < kCount;) {
      Block block;
      block.fill(value);
      if (ring.push(block)) {
        ++value;
      } else {
        std::this_thread::yield();
      }
    }
  }};
  Block block;
  for (std::uint64_t expected = 0; expected < kCount;) {
    if (!ring.pop(block)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_TRUE(std::all_of(block.begin(), block.end(), [&](std::uint64_t x) { return x == expected; }));
    ++expected;
  }
  writer.join();
}

TEST(LatencyHistogram, IsEmptyAtFirst) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.summary().count, 0u);
  EXPECT_EQ(histogram.summary().p999_us, 0);
}

TEST(LatencyHistogram, ReadsPercentilesBackWithinThreePercent) {
  constexpr std::uint64_t kSeed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random{kSeed};
  std::lognormal_distribution<double> latency_ns{11.5, 1.5};
  LatencyHistogram histogram;
  std::vector<double> all;
  for (int i = 0; i < 100'000; ++i) {
    const auto ns = static_cast<std::int64_t>(latency_ns(random));
    histogram.record(std::chrono::nanoseconds{ns});
    all.push_back(static_cast<double>(ns) / 1e3);
  }
  std::sort(all.begin(), all.end());
  const LatencyHistogram::Summary summary = histogram.summary();
  EXPECT_EQ(summary.count, all.size());
  const auto expect_close = [&](double actual, double fraction) {
    const double exact =
        all[static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(all.size()))) - 1];
    EXPECT_GE(actual, exact * (1 - 1e-9));
    EXPECT_LE(actual, exact * (1 + 1.0 / 32));
  };
  expect_close(summary.p50_us, 0.5);
  expect_close(summary.p99_us, 0.99);
  expect_close(summary.p999_us, 0.999);
  EXPECT_EQ(summary.max_us, all.back());
}

TEST(LatencyHistogram, TakesTheShortestAndTheLongestDurations) {
  LatencyHistogram histogram;
  for (const auto ns :
       {std::chrono::nanoseconds::min(), std::chrono::nanoseconds{-1}, std::chrono::nanoseconds{0},
        std::chrono::nanoseconds{31}, std::chrono::nanoseconds{32}, std::chrono::nanoseconds::max()}) {
    histogram.record(ns);
  }
  EXPECT_EQ(histogram.summary().count, 6u);
  EXPECT_EQ(histogram.summary().p50_us, 0);
  EXPECT_NEAR(histogram.summary().max_us, 9.22e15, 1e13);
}

TEST(StreamCycle, IsCommandedAndReadFromOtherThreadsWhileItRuns) {
  StreamRig rig;
  std::atomic<bool> done{false};
  std::thread commander{[&] {
    for (std::uint64_t i = 1; i <= 200; ++i) {
      rig.cycle->use_model(real_arm(i % 2 == 0 ? 1 : -1), i);
      i % 3 == 0 ? rig.cycle->disengage() : rig.cycle->engage();
      rig.cycle->acknowledge();
      std::this_thread::yield();
    }
    done = true;
  }};
  std::thread reader{[&] {
    std::uint64_t last = 0;
    while (!done) {
      const StreamStatus status = rig.cycle->status();
      EXPECT_GE(status.counters.datagrams, last);
      last = status.counters.datagrams;
      const StreamCounters& c = status.counters;
      EXPECT_EQ(c.datagrams, c.answered + c.held + c.duplicate + c.wrong_ipoc + c.unconfirmed + c.unanswered)
          << "a torn status";
      rig.cycle->turnaround();
      for (StreamEvent event; rig.cycle->next_event(event);) EXPECT_LE(event.value, 5'000'000u);
    }
  }};
  while (!done) rig.tick();
  commander.join();
  reader.join();
  rig.ticks(2);
  EXPECT_EQ(rig.status().model, 200u);
}

}  // namespace
}  // namespace truepose::daemon
