#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/daemon/recorded_life.hpp"

namespace truepose::daemon {
namespace {

using recording::Kind;
using recording::Record;
using recording::Wire;

TEST(ARecorder, LosesNothingThatThreadsTellItWhileItDrains) {
  constexpr int kCount = 2000;
  RecordedLife life;
  std::atomic<int> running = 2;
  std::thread realtime{[&] {
    for (int i = 0; i < kCount; ++i) life.rig.tick();
    --running;
  }};
  std::thread drivers{[&] {
    for (int i = 0; i < kCount; ++i) life.recorder.tell(Wire::Tracker, Kind::Received, std::to_string(i));
    --running;
  }};
  while (running > 0) {
    life.recorder.drain();
    EXPECT_EQ(life.recorder.status().dropped, 0U);
  }
  realtime.join();
  drivers.join();
  int datagrams = 0, packets = 0;
  const std::string damage = life.saved().for_each([&](const Record& record) {
    if (record.kind != Kind::Received) return;
    if (record.wire == Wire::Rsi) ++datagrams;
    if (record.wire != Wire::Tracker) return;
    EXPECT_EQ(record.bytes, std::to_string(packets++));
  });
  EXPECT_EQ(damage, "");
  EXPECT_EQ(datagrams, kCount);
  EXPECT_EQ(packets, kCount);
}

}  // namespace
}  // namespace truepose::daemon
