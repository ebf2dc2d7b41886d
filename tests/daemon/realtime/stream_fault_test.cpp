#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "daemon/realtime/stream_cycle.hpp"
#include "tests/daemon/engaged_stream.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(StreamFault, FaultsHoldsAndAsksToStopWhenABoundIsBrokenForLong) {
  StreamOptions options = stream_options();
  options.max_total_rad = 0.03 * kRadPerDeg;
  StreamRig rig{options};
  rig.settle();
  rig.cycle->use_model(real_arm(3), 1);
  rig.cycle->engage();
  rig.ticks(kRamp);
  EXPECT_FALSE(rig.stop);
  rig.ticks(kRamp);
  EXPECT_EQ(rig.state(), StreamState::Fault);
  EXPECT_EQ(rig.status().fault, StreamFault::BoundBroken);
  EXPECT_NE(reason(rig.status()).find("where the bound is 0.030 deg"), std::string::npos)
      << reason(rig.status());
  EXPECT_TRUE(rig.stop);
  EXPECT_GT(rig.status().counters.clamped_total, 240u);
  EXPECT_LE(rig.largest_applied_deg(), 0.03 + kWireDeg);

  const JointVector before = rig.applied;
  rig.q[0] += 2 * kRadPerDeg;
  rig.ticks(10);
  EXPECT_EQ(rig.applied, before);

  rig.cycle->disengage();
  rig.cycle->acknowledge();
  rig.ticks(kRamp + 2);
  EXPECT_FALSE(rig.stop);
  EXPECT_TRUE(rig.applied.isZero(0));
  EXPECT_EQ(rig.state(), StreamState::Idle);
}

TEST(StreamFault, NamesAxisValueAndLimitWhereTheArmIsBeyondAJointLimit) {
  struct Case {
    double a1_deg, margin_deg;
    const char* line;
  };
  for (const Case& one :
       {Case{-186, 0, "A1 with its correction is at -186.0"}, Case{186, 1, "A1 with its correction is at 18"},
        Case{184.5, 1, "A1 with its correction is at 184."},
        Case{-184.5, 1, "A1 with its correction is at -184."}}) {
    StreamOptions options = stream_options();
    options.limit_margin_rad = one.margin_deg * kRadPerDeg;
    std::string said;
    for (const double scale : {3.0, -3.0}) {  // one of them leads outwards
      StreamRig rig{options};
      rig.q[0] = one.a1_deg * kRadPerDeg;
      rig.settle();
      rig.cycle->use_model(real_arm(scale), 1);
      rig.cycle->engage();
      rig.ticks(3 * kRamp);
      if (rig.status().fault != StreamFault::JointLimit) {
        EXPECT_EQ(rig.status().fault, StreamFault::None) << reason(rig.status());
        continue;
      }
      EXPECT_EQ(rig.status().detail.axis, 1);
      EXPECT_TRUE(rig.stop);
      said = reason(rig.status());
    }
    EXPECT_THAT(said, HasSubstr(one.line));
    const double limit_deg = std::copysign(185 - one.margin_deg, one.a1_deg);
    EXPECT_THAT(said, HasSubstr("beyond its limit of " + std::to_string(limit_deg).substr(0, 6)));
    EXPECT_THAT(said, Not(HasSubstr("singularity")));
    EXPECT_THAT(said, Not(HasSubstr("model")));
  }
}

TEST(StreamFault, AsksToLeaveRsiOnceNothingIsInForceAndAgainAfterEachReplyThatIsLost) {
  StreamRig rig;
  rig.settle();
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(kRamp + 1);
  rig.cycle->leave();
  for (int i = 0; i < kRamp + 2 && !rig.stop; ++i) rig.tick();
  EXPECT_TRUE(rig.stop);
  EXPECT_TRUE(rig.applied.isZero(0)) << "not before";
  for (int i = 0; i < 5; ++i) {
    rig.tick({.reply_lost = true});
    EXPECT_FALSE(rig.stop) << "a pulse";
    rig.tick();
    EXPECT_TRUE(rig.stop);
  }
  rig.restart(1'000);
  rig.ticks(10);
  EXPECT_FALSE(rig.stop) << "of another program";
  EXPECT_EQ(rig.state(), StreamState::Idle);
}

TEST(StreamFault, FreezesWhenTheAxesDoNotFollowAndGoesOnWhenAcknowledged) {
  StreamRig rig;
  rig.stuck = rig.q;  // the program is stopped
  rig.settle();
  rig.cycle->use_model(real_arm(3), 1);
  rig.cycle->engage();
  rig.ticks(3 * kRamp);
  EXPECT_EQ(rig.state(), StreamState::Frozen);
  const JointVector before = rig.applied;
  rig.ticks(100);
  EXPECT_EQ(rig.applied, before);
  EXPECT_FALSE(rig.stop);

  rig.stuck.reset();
  rig.ticks(100);
  EXPECT_EQ(rig.state(), StreamState::Frozen) << "only a person re-arms";
  EXPECT_NEAR(rig.status().detail.value, 0, 0.03) << reason(rig.status());
  EXPECT_GT(rig.status().detail.limit, 0.1) << "what was sent to that axis";
  rig.cycle->acknowledge();
  rig.ticks(2 * kRamp);
  EXPECT_EQ(rig.state(), StreamState::Active);
  expect_near_deg(rig.applied, expected_correction(real_arm(3), rig.q), kWireDeg);
}

TEST(StreamFault, IsNotFrozenByAnArmThatTrailsItsCommandInMotion) {
  StreamRig rig;
  engage(rig);
  constexpr std::size_t kDeadCycles = 25;
  std::vector<JointVector> given(kDeadCycles, rig.q + rig.applied);
  for (std::size_t i = 0; i < 3000; ++i) {
    rig.q[0] += 0.02 * kRadPerDeg;
    given.push_back(rig.q + rig.applied);
    rig.stuck = given[i];
    rig.tick();
  }
  EXPECT_EQ(rig.state(), StreamState::Active);
}

TEST(StreamFault, ConcludesNothingOfTheArmFromAxesThatItCannotHaveReached) {
  StreamRig rig;
  engage(rig);
  rig.ticks(600);
  ASSERT_TRUE(rig.status().measured_deg[0]);
  rig.q[0] += 30 * kRadPerDeg;
  rig.ticks(20);
  EXPECT_FALSE(rig.status().measured_deg[0]) << "of the second before";
  rig.ticks(600);
  ASSERT_TRUE(rig.status().measured_deg[0]);
  EXPECT_NEAR(*rig.status().measured_deg[0], rig.status().correction_deg[0], 1e-4);
}

TEST(StreamFault, SaysThatTheControllerRejectsRepliesThatWereSentInTime) {
  StreamRig rig;
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  for (int i = 0; i < 20; ++i) rig.tick({.rejected = true});
  EXPECT_EQ(rig.status().fault, StreamFault::RepliesRejected);
  EXPECT_NE(reason(rig.status()).find("SENTYPE"), std::string::npos);
  EXPECT_TRUE(rig.applied.isZero(0));
}

TEST(StreamFault, BlamesNoControllerThatTookRepliesForABurstThatTheNetworkLost) {
  StreamRig rig;
  engage(rig);
  for (int i = 0; i < 60; ++i) rig.tick({.reply_lost = true});
  EXPECT_EQ(rig.status().fault, StreamFault::None);
  rig.ticks(2 * kRamp);
  EXPECT_EQ(rig.state(), StreamState::Active);
}

TEST(StreamFault, PutsABacklogOfLateRepliesDownToNobodyAndResumesWithoutAJump) {
  StreamRig rig;
  engage(rig);
  std::vector<std::string> backlog;  // 100 ms in which this process was stopped
  for (int i = 0; i < 25; ++i) {
    rig.ipoc += rig.step;
    rig.q[0] += 0.2 * kRadPerDeg;
    backlog.push_back(rig.datagram());
    ++rig.delay;
  }
  for (const std::string& datagram : backlog) EXPECT_FALSE(rig.send(datagram).empty());
  rig.ticks(50);  // the rig checks each step
  EXPECT_EQ(rig.status().fault, StreamFault::None);
  EXPECT_EQ(rig.status().counters.late, 25u);
  expect_near_deg(rig.applied, expected_correction(real_arm(), rig.q), kWireDeg);
}

}  // namespace
}  // namespace truepose::daemon
