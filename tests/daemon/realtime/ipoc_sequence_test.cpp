#include <gtest/gtest.h>

#include "daemon/realtime/controller_session.hpp"

namespace truepose::daemon {
namespace {

using Place = IpocSequence::Place;

/// A session of 100 datagrams, 4 ms apart, that ends with `last`.
IpocSequence session_until(std::uint64_t last) {
  IpocSequence sequence{100};
  sequence.start(last - 400);
  for (std::uint64_t ipoc = last - 396; ipoc <= last; ipoc += 4) sequence.advance(ipoc, sequence.place(ipoc));
  return sequence;
}

TEST(IpocSequence, BeginsWithTheVeryFirstDatagram) {
  IpocSequence sequence{100};
  EXPECT_EQ(sequence.place(7).place, Place::Jump);
  EXPECT_TRUE(sequence.bears_out(7));
}

TEST(IpocSequence, LearnsTheStepFromTwoInARowAndNotFromAGap) {
  IpocSequence sequence{100};
  sequence.start(1000);
  for (const std::uint64_t ipoc : {1012u, 1016u}) sequence.advance(ipoc, sequence.place(ipoc));
  EXPECT_EQ(sequence.step(), 0u);
  sequence.advance(1020, sequence.place(1020));
  EXPECT_EQ(sequence.step(), 4u);
  EXPECT_EQ(sequence.last(), 1020u);
}

TEST(IpocSequence, CountsTheCyclesOfAGap) {
  const IpocSequence sequence = session_until(10'000);
  EXPECT_EQ(sequence.place(10'004).elapsed, 1u);
  const auto gap = sequence.place(10'040);
  EXPECT_EQ(gap.place, Place::Next);
  EXPECT_EQ(gap.elapsed, 10u);
  EXPECT_EQ(gap.forward, 40u);
}

TEST(IpocSequence, RoundsAStampThatIsAMillisecondOff) {
  const IpocSequence sequence = session_until(10'000);
  EXPECT_EQ(sequence.place(10'009).elapsed, 2u);
  EXPECT_EQ(sequence.place(10'011).elapsed, 3u);
  EXPECT_EQ(sequence.place(10'001).place, Place::Stale);
}

TEST(IpocSequence, KnowsRepeatedAndOvertakenDatagrams) {
  const IpocSequence sequence = session_until(10'000);
  EXPECT_EQ(sequence.place(10'000).place, Place::Duplicate);
  EXPECT_EQ(sequence.place(9'996).place, Place::Stale);
  EXPECT_EQ(sequence.place(9'600).place, Place::Stale);
}

TEST(IpocSequence, TakesALongGapAndAFarStepBackForAJump) {
  const IpocSequence sequence = session_until(10'000);
  EXPECT_EQ(sequence.place(10'400).place, Place::Next);
  EXPECT_EQ(sequence.place(10'404).place, Place::Jump);
  EXPECT_EQ(sequence.place(9'599).place, Place::Jump);
  EXPECT_EQ(sequence.place(0).place, Place::Jump);
}

TEST(IpocSequence, BelievesAJumpOnlyWithTheThirdDatagramThatGoesOnFromIt) {
  IpocSequence sequence = session_until(10'000);
  EXPECT_FALSE(sequence.bears_out(500));
  EXPECT_FALSE(sequence.bears_out(504));
  EXPECT_FALSE(sequence.bears_out(9'000'000));
  EXPECT_FALSE(sequence.bears_out(9'000'004));
  EXPECT_TRUE(sequence.bears_out(9'000'008));
}

TEST(IpocSequence, ForgetsADamagedStampWhenTheSessionGoesOn) {
  IpocSequence sequence = session_until(10'000);
  EXPECT_FALSE(sequence.bears_out(500));
  EXPECT_FALSE(sequence.bears_out(504));
  sequence.advance(10'004, sequence.place(10'004));
  EXPECT_FALSE(sequence.bears_out(508));
}

TEST(IpocSequence, ContinuesWhereACounterOf32BitsOverflows) {
  const std::uint64_t full = std::uint64_t{1} << 32;
  const IpocSequence sequence = session_until(full - 2);
  const auto next = sequence.place(2);
  EXPECT_EQ(next.place, Place::Next);
  EXPECT_EQ(next.elapsed, 1u);
}

}  // namespace
}  // namespace truepose::daemon
