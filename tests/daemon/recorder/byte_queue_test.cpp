#include "daemon/recorder/byte_queue.hpp"

#include <gtest/gtest.h>

#include <string>
#include <thread>

namespace truepose::daemon {
namespace {

TEST(ByteQueue, GivesTextsOfAnySizeInTheirOrderOverItsEnd) {
  ByteQueue queue{64};
  std::string text;
  EXPECT_FALSE(queue.pop(text));
  for (std::size_t size = 0; size < 60; ++size) {
    const std::string first(size / 2, 'a'), second(size - size / 2, 'b');
    ASSERT_TRUE(queue.push({first, second}));
    ASSERT_TRUE(queue.pop(text));
    EXPECT_EQ(text, first + second);
  }
}

TEST(ByteQueue, CountsWhatItHasNoRoomFor) {
  ByteQueue queue{64};
  EXPECT_TRUE(queue.push({std::string(40, 'x')}));
  EXPECT_FALSE(queue.push({std::string(20, 'y')}));
  EXPECT_EQ(queue.dropped(), 1U);
  std::string text;
  EXPECT_TRUE(queue.pop(text));
  EXPECT_FALSE(queue.pop(text)) << "a text that was dropped leaves no part";
}

TEST(ByteQueue, LosesTearsAndReordersNothingBetweenThreads) {
  constexpr std::size_t kCount = 100'000;
  ByteQueue queue{4096};
  std::thread writer{[&] {
    for (std::size_t i = 0; i < kCount;) {
      const std::string text = std::to_string(i);
      if (queue.push({std::string_view{text}, std::string_view{text}})) {
        ++i;
      } else {
        std::this_thread::yield();
      }
    }
  }};
  std::string text;
  for (std::size_t i = 0; i < kCount;) {
    if (!queue.pop(text)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(text, std::to_string(i) + std::to_string(i));
    ++i;
  }
  writer.join();
}

}  // namespace
}  // namespace truepose::daemon
