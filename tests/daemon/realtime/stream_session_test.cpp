#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "daemon/realtime/stream_cycle.hpp"
#include "tests/daemon/engaged_stream.hpp"

namespace truepose::daemon {
namespace {

TEST(StreamSession, HoldsTheCorrectionThroughLostDatagramsAndCountsThem) {
  StreamRig rig;
  engage(rig);
  for (int i = 0; i < 20; ++i) {
    for (int lost = 0; lost <= i % 5; ++lost) rig.tick({.datagram_lost = true});
    rig.q[1] += 0.05 * kRadPerDeg;
    rig.ticks(3);
  }
  EXPECT_EQ(rig.status().counters.lost, 60u);
  EXPECT_EQ(rig.status().counters.late, 0u) << "what was never asked is no late reply";
  EXPECT_EQ(rig.status().counters.sessions, 1u);
  EXPECT_EQ(rig.state(), StreamState::Active);
}

TEST(StreamSession, DoesNotMoveOnWhileTheControllerDoesNotTakeItsReplies) {
  StreamOptions options = stream_options();
  options.rejected_cycles = 1'000'000;
  StreamRig rig{options};
  rig.settle();
  rig.cycle->use_model(real_arm(3), 1);
  rig.cycle->engage();
  rig.ticks(100);
  for (int i = 0; i < 50; ++i) rig.tick({.reply_lost = true});
  rig.ticks(kRamp);  // the rig itself checks that no step is too large
  EXPECT_EQ(rig.status().counters.late, 50u);
  EXPECT_EQ(rig.state(), StreamState::Active);
}

TEST(StreamSession, HoldsOnAFrameThatItCannotBelieve) {
  StreamRig rig;
  engage(rig);
  const JointVector before = rig.applied;
  const std::int64_t delay = rig.delay;
  rig.q[0] += 1 * kRadPerDeg;
  for (const std::string body :
       {"", "<AIPos A1=\"1\"/>", "<ASPos A1=\"nan\" A2=\"1\" A3=\"1\" A4=\"1\" A5=\"1\" A6=\"1\"/>",
        "<ASPos A1=\"1e999\" A2=\"1\" A3=\"1\" A4=\"1\" A5=\"1\" A6=\"1\"/>", "<<<"}) {
    const std::string ipoc = std::to_string(rig.ipoc + 4);
    rig.tick({.replaced_by = "<Rob Type=\"KUKA\">" + body + "<IPOC>" + ipoc + "</IPOC></Rob>"});
    EXPECT_EQ(rig.applied, before) << body;
  }
  const StreamStatus status = rig.status();
  EXPECT_EQ(status.counters.malformed, 5u);
  EXPECT_EQ(status.counters.held, 5u);
  EXPECT_EQ(status.counters.lost, 0u);
  EXPECT_EQ(rig.delay, delay);
}

TEST(StreamSession, DoesNotAnswerWithoutAReadableIpoc) {
  StreamRig rig;
  engage(rig);
  for (const char* bytes :
       {"", "x", "<Rob Type=\"KUKA\"></Rob>", "<IPOC></IPOC>", "<IPOC>12", "<IPOC>-5</IPOC>",
        "<IPOC>99999999999999999999999</IPOC>", "<IPOC>1</IPOC><IPOC>2</IPOC>"}) {
    EXPECT_EQ(rig.send(bytes), "") << bytes;
  }
  EXPECT_EQ(rig.status().counters.unanswered, 8u);
  EXPECT_EQ(rig.status().counters.malformed, 8u);
  EXPECT_EQ(count_events(*rig.cycle, StreamEventKind::Malformed), 1);
}

TEST(StreamSession, GivesARepeatedIpocTheSameReply) {
  StreamRig rig;
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(50);
  const std::string reply = rig.tick();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(rig.send(rig.datagram()), reply);
  EXPECT_EQ(rig.status().counters.duplicate, 3u);
}

TEST(StreamSession, DoesNotAnswerAnIpocThatComesTooLate) {
  StreamRig rig;
  engage(rig);
  const std::string early = rig.datagram();
  rig.ticks(3);
  const JointVector before = rig.applied;
  EXPECT_EQ(rig.send(early), "");
  rig.tick();
  EXPECT_EQ(rig.applied, before);
  EXPECT_EQ(rig.status().counters.wrong_ipoc, 1u);
  EXPECT_EQ(rig.status().counters.sessions, 1u);
}

TEST(StreamSession, BeginsAtZeroAndRampsInAgainWhenTheControllerRestarts) {
  for (const std::uint64_t new_ipoc : {std::uint64_t{100}, std::uint64_t{8'000'000}}) {
    StreamRig rig;
    engage(rig);
    rig.restart(new_ipoc);
    rig.ticks(6);  // of which it answers none or with next to nothing
    EXPECT_LT(rig.largest_applied_deg(), 0.001);
    EXPECT_EQ(rig.state(), StreamState::RampingIn);
    rig.ticks(kRamp + 1);
    expect_near_deg(rig.applied, expected_correction(real_arm(), rig.q), kWireDeg);
  }
}

TEST(StreamSession, KnowsByTheAxesThatTheControllerRestartedAfterAShortGap) {
  StreamRig rig;
  engage(rig, real_arm(4));
  rig.restart(rig.ipoc + 4 * 50);
  rig.ticks(5);
  EXPECT_EQ(rig.state(), StreamState::RampingIn);
  EXPECT_LT(rig.largest_applied_deg(), 0.001);
}

TEST(StreamSession, KnowsByTheCountOfMissedRepliesThatTheControllerRestartedWhereTheAxesDoNotShowIt) {
  rsi::EthernetConfig config = ethernet_config();
  std::erase_if(config.send, [](const rsi::Element& element) { return element.tag == "DEF_ASPos"; });
  StreamRig rig{stream_options(), config};
  engage(rig, real_arm(4));
  rig.restart(rig.ipoc + 4 * 50);
  rig.ticks(2);
  EXPECT_EQ(rig.state(), StreamState::Unproven) << "one frame may be damaged, and two";
  rig.ticks(2);
  EXPECT_EQ(rig.state(), StreamState::RampingIn);
  EXPECT_LT(rig.largest_applied_deg(), 0.001);
}

TEST(StreamSession, GoesOnAtOnceAfterAGapInWhichTheControllerCountedEveryCycle) {
  StreamRig rig;
  engage(rig, real_arm(4));
  const JointVector before = rig.applied;
  for (int lost = 0; lost < 60; ++lost) {
    rig.q[0] += 0.8 * kRadPerDeg;  // 200 deg/s: the axes could not tell
    rig.tick({.datagram_lost = true});
  }
  EXPECT_FALSE(rig.tick().empty());
  EXPECT_NE(before, JointVector(JointVector::Zero(6)));
  EXPECT_EQ(rig.status().counters.unconfirmed, 3u);
}

TEST(StreamSession, IsSilentToTheNearlyEmptyFirstFrameOfOldControllersAndThenRampsIn) {
  StreamRig rig;
  engage(rig);
  rig.restart(100);
  EXPECT_EQ(rig.tick({.replaced_by = "<Rob Type=\"KUKA\"><IPOC>104</IPOC></Rob>"}), "");
  rig.ticks(kRamp + 10);
  expect_near_deg(rig.applied, expected_correction(real_arm(), rig.q), kWireDeg);
}

TEST(StreamSession, IsNotDeceivedByOneDamagedTimeStamp) {
  StreamRig rig;
  engage(rig);
  const JointVector before = rig.applied;
  for (const std::uint64_t damaged :
       {std::uint64_t{0}, std::uint64_t{99'999'999}, rig.ipoc + 1, ~std::uint64_t{0}}) {
    const std::uint64_t ipoc = std::exchange(rig.ipoc, damaged);
    const std::string datagram = rig.datagram();
    rig.ipoc = ipoc;
    EXPECT_EQ(rig.send(datagram), "");
    rig.ticks(5);
    EXPECT_EQ(rig.applied, before);
  }
  EXPECT_EQ(rig.status().counters.sessions, 1u);
  EXPECT_EQ(rig.status().ipoc_step, 4u);
}

TEST(StreamSession, KeepsItsCorrectionWhereAThirtyTwoBitIpocIsFull) {
  StreamRig rig;
  rig.ipoc = (std::uint64_t{1} << 32) - 4 * 300 - 2;
  engage(rig);
  const JointVector before = rig.applied;
  for (int i = 0; i < 100; ++i) {
    if (rig.ipoc + rig.step >= std::uint64_t{1} << 32) rig.ipoc -= std::uint64_t{1} << 32;
    rig.tick();
    ASSERT_EQ(rig.applied, before);
  }
  EXPECT_LT(rig.ipoc, 1000u);
  EXPECT_EQ(rig.status().counters.sessions, 1u);
  EXPECT_EQ(rig.status().counters.lost, 0u);
  EXPECT_EQ(rig.status().counters.wrong_ipoc, 0u);
}

}  // namespace
}  // namespace truepose::daemon
