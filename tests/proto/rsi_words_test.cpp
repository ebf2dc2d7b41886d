// The whole numbers in which a packet has several things.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <optional>

#include "proto/rsi/cell_word.hpp"
#include "proto/rsi/gain_word.hpp"

namespace truepose::rsi {
namespace {

TEST(GainWord, IsAnotherOneInEveryCycleAndFitsIntoAnIntegerOfTheController) {
  std::int64_t before = 0;
  for (std::uint64_t ipoc = 4208163; ipoc < 4208163 + 4'000'000; ipoc += 4) {
    const std::int64_t word = gain_word(kGainNoModel, ipoc);
    ASSERT_NE(word, before);
    ASSERT_GT(word, std::numeric_limits<std::int32_t>::min());
    ASSERT_EQ(gain_of(word), kGainNoModel);
    before = word;
  }
  EXPECT_EQ(gain_of(gain_word(100, 0)), 100);
  for (const int nothing : {0, 100, -9}) EXPECT_EQ(gain_of(nothing), std::nullopt);
}

TEST(CellWord, TellsStopGateAndToolOfWhoCounts) {
  EXPECT_EQ(cell_signals(1024),
            (CellSignals{.emergency_stop = false, .gate_open = false, .tool = {}, .count = 1}));
  EXPECT_EQ(cell_signals(1000 * 1024 + 4 * 255 + 2),
            (CellSignals{.emergency_stop = false, .gate_open = true, .tool = 255, .count = 1000}));
  EXPECT_EQ(cell_signals(17 * 1024 + 4 * 3 + 1),
            (CellSignals{.emergency_stop = true, .gate_open = false, .tool = 3, .count = 17}));
  for (const std::int64_t nobodys : {0L, 1L, 1023L, 1001L * 1024, -1L, -1024L, std::int64_t{1} << 60})
    EXPECT_FALSE(cell_signals(nobodys)) << nobodys;
}

}  // namespace
}  // namespace truepose::rsi
