#include "tools/proxy/faulty_way.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace truepose::proxy {
namespace {

using testing::ElementsAre;

std::vector<std::string> sent(FaultyWay& way, std::string_view bytes) {
  std::vector<std::string> sent;
  for (FaultyWay::Outgoing& out : way.datagram(bytes)) sent.push_back(std::move(out.bytes));
  return sent;
}

/// What of 20,000 numbered datagrams continues.
std::vector<std::string> passed(FaultyWay& way) {
  std::vector<std::string> all;
  for (int i = 0; i < 20'000; ++i) {
    for (std::string& one : sent(way, std::to_string(i))) all.push_back(std::move(one));
  }
  return all;
}

TEST(AFaultyWay, ChangesNothingUntilItIsSet) {
  FaultyWay way{1};
  const auto out = way.datagram("abc");
  ASSERT_EQ(out.size(), 1);
  EXPECT_EQ(out[0].bytes, "abc");
  EXPECT_EQ(out[0].delay.count(), 0);
}

TEST(AFaultyWay, DoesTheSameAgainFromTheSameSeed) {
  const auto all = [](std::uint64_t seed) {
    FaultyWay way{seed};
    way.faults = {.truncate = 0.1, .corrupt = 0.1, .loss = 0.1, .burst = 3, .duplicate = 0.1, .reorder = 0.1};
    return passed(way);
  };
  EXPECT_EQ(all(5), all(5));
  EXPECT_NE(all(5), all(6));
}

TEST(AFaultyWay, LosesItsShareInRowsOfTheMeanLength) {
  for (const double burst : {1.0, 4.0}) {
    FaultyWay way{7};
    way.faults.loss = 0.2;
    way.faults.burst = burst;
    int rows = 0, lost = 0;
    bool before = false;
    for (int i = 0; i < 20'000; ++i) {
      const bool gone = way.datagram("x").empty();
      lost += gone;
      rows += gone && !before;
      before = gone;
    }
    EXPECT_NEAR(lost, 4000, 400) << burst;
    EXPECT_NEAR(static_cast<double>(lost) / rows, burst, burst * 0.15) << burst;
    EXPECT_EQ(way.counters().lost, static_cast<std::uint64_t>(lost));
  }
}

TEST(AFaultyWay, LosesEverythingOrNothingAtTheEnds) {
  FaultyWay way{1};
  way.faults.loss = 1;
  EXPECT_THAT(sent(way, "a"), ElementsAre());
  way.faults.loss = 0;
  EXPECT_THAT(sent(way, "b"), ElementsAre("b"));
}

TEST(AFaultyWay, PutsADatagramBehindTheNextOne) {
  FaultyWay way{1};
  way.faults.reorder = 1;
  EXPECT_THAT(sent(way, "a"), ElementsAre());
  EXPECT_THAT(sent(way, "b"), ElementsAre("b", "a"));
}

TEST(AFaultyWay, SendsADatagramTwice) {
  FaultyWay way{1};
  way.faults.duplicate = 1;
  EXPECT_THAT(sent(way, "a"), ElementsAre("a", "a"));
}

TEST(AFaultyWay, CutsTheEndOff) {
  FaultyWay way{3};
  way.faults.truncate = 1;
  for (int i = 0; i < 100; ++i) {
    const std::string cut = sent(way, "0123456789").at(0);
    EXPECT_LT(cut.size(), 10);
    EXPECT_TRUE(std::string{"0123456789"}.starts_with(cut));
  }
}

TEST(AFaultyWay, ChangesOneByte) {
  FaultyWay way{3};
  way.faults.corrupt = 1;
  const std::string whole = "0123456789";
  for (int i = 0; i < 100; ++i) {
    const std::string garbled = sent(way, whole).at(0);
    ASSERT_EQ(garbled.size(), whole.size());
    int changed = 0;
    for (std::size_t byte = 0; byte < whole.size(); ++byte) changed += garbled[byte] != whole[byte];
    EXPECT_EQ(changed, 1);
  }
}

TEST(AFaultyWay, PutsNulBytesBehind) {
  FaultyWay way{1};
  way.faults.nul_bytes = 3;
  EXPECT_EQ(sent(way, "ab").at(0), std::string("ab\0\0\0", 5));
}

TEST(AFaultyWay, DelaysByTheFixedTimeAndAtMostTheJitterMore) {
  FaultyWay way{9};
  way.faults.delay_ms = 5;
  way.faults.jitter_ms = 2;
  for (int i = 0; i < 100; ++i) {
    const auto delay = way.datagram("x").at(0).delay;
    EXPECT_GE(delay.count(), 5000);
    EXPECT_LE(delay.count(), 7000);
  }
}

TEST(AFaultyWay, NeitherLosesNorReordersAPieceOfAStream) {
  FaultyWay way{1};
  way.faults = {.loss = 1, .duplicate = 1, .reorder = 1};
  EXPECT_EQ(way.piece("a").bytes, "a");
  EXPECT_EQ(way.piece("b").bytes, "b");
}

}  // namespace
}  // namespace truepose::proxy
