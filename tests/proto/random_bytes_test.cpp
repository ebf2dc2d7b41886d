#include "proto/text/random_bytes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace truepose {
namespace {

RandomBytes always(unsigned char byte) {
  return [byte](std::span<unsigned char> bytes) { std::ranges::fill(bytes, byte); };
}

TEST(RandomHex, GivesTwoDigitsAByteAndNeverTheSame) {
  EXPECT_EQ(random_hex(16, kernel_random).size(), 32U);
  EXPECT_NE(random_hex(16, kernel_random), random_hex(16, kernel_random));
}

TEST(RandomUuid, IsOfVersionFourWhateverIsDrawn) {
  EXPECT_EQ(random_uuid(always(0x00)), "00000000-0000-4000-8000-000000000000");
  EXPECT_EQ(random_uuid(always(0xff)), "ffffffff-ffff-4fff-bfff-ffffffffffff");
  EXPECT_EQ(random_uuid(always(0x6a)), "6a6a6a6a-6a6a-4a6a-aa6a-6a6a6a6a6a6a");
  EXPECT_NE(random_uuid(kernel_random), random_uuid(kernel_random));
}

}  // namespace
}  // namespace truepose
