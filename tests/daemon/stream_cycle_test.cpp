#include "daemon/realtime/stream_cycle.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/simulate/published_arm.hpp"
#include "tests/allocations.hpp"
#include "tests/daemon/heavy_model.hpp"
#include "tests/daemon/stream_rig.hpp"
#include "tests/sanitized.hpp"
#include "tests/system_calls.hpp"

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;

constexpr double kWireDeg = 1.01e-6;  // what six decimals can be off
constexpr int kRamp = 250;            // cycles

JointVector expected_correction(const RobotModel& model, const JointVector& q) {
  return TargetCompensation(nominal_arm(), model).at_joints(q)->q - q;
}

void expect_near_deg(const JointVector& actual, const JointVector& expected, double tolerance_deg) {
  EXPECT_LE((actual - expected).cwiseAbs().maxCoeff() * kDegPerRad, tolerance_deg)
      << "actual " << actual.transpose() * kDegPerRad << "\nexpected " << expected.transpose() * kDegPerRad;
}

/// A stream with the real arm's model, all the way in.
void engage(StreamRig& rig, const RobotModel& model = real_arm()) {
  rig.settle();
  rig.cycle->use_model(model, 1);
  rig.cycle->engage();
  rig.ticks(kRamp + 2);
  ASSERT_EQ(rig.state(), StreamState::Active);
  ASSERT_GT(rig.largest_applied_deg(), 0.02);
}

int count_events(StreamCycle& cycle, StreamEventKind kind) {
  int count = 0;
  for (StreamEvent event; cycle.next_event(event);) count += event.kind == kind;
  return count;
}

TEST(StreamCycle, AnswersEveryDatagramWithItsOwnIpocAndNoCorrectionWhileIdle) {
  StreamRig rig;
  rig.settle();
  for (int i = 0; i < 100; ++i) {
    const rsi::SensorFrame reply = rig.decode(rig.tick());
    ASSERT_EQ(reply.ipoc, rig.ipoc);
    ASSERT_EQ(*reply.axis_correction_rad, rsi::Axes{});
    ASSERT_EQ(reply.stop, false);
  }
  const StreamStatus status = rig.status();
  EXPECT_EQ(status.counters.datagrams, 104u);
  EXPECT_EQ(status.counters.answered, 101u);
  EXPECT_EQ(status.counters.unproven, 3u) << "the first cycles show that nothing is in force";
  EXPECT_EQ(status.counters.sessions, 1u);
  EXPECT_EQ(status.counters.late, 0u);
  EXPECT_EQ(status.ipoc_step, 4u);
  EXPECT_EQ(status.state, StreamState::Idle);
}

TEST(StreamCycle, CorrectsNothingWhereTheRealArmIsTheNominalOne) {
  StreamRig rig;
  rig.settle();
  rig.cycle->use_model(nominal_arm(), 1);
  rig.cycle->engage();
  for (int i = 0; i < 2 * kRamp; ++i) {
    rig.q[0] += 0.05 * kRadPerDeg;
    rig.tick();
    ASSERT_TRUE(rig.applied.isZero(0));
  }
  EXPECT_EQ(rig.state(), StreamState::Active);
}

TEST(StreamCycle, SendsCompensatedLessCommandedAxesAfterTheRamp) {
  StreamRig rig;
  engage(rig);
  expect_near_deg(rig.applied, expected_correction(real_arm(), rig.q), kWireDeg);
  for (int i = 0; i < 2000; ++i) {
    rig.q += axes_deg({0.02, -0.005, 0.01, 0.01, 0.008, -0.02});
    rig.tick();
    ASSERT_NO_FATAL_FAILURE(expect_near_deg(rig.applied, expected_correction(real_arm(), rig.q), kWireDeg));
  }
  EXPECT_EQ(rig.status().counters.held, 0u);
  EXPECT_LE(rig.status().max_step_deg, 0.02 + 1e-9);
}

TEST(StreamCycle, TakesItsOwnCorrectionOutOfTheActualAxesWhereTheCommandedOnesAreNotSent) {
  rsi::EthernetConfig config = ethernet_config();
  std::erase_if(config.send, [](const rsi::Element& element) { return element.tag == "DEF_ASPos"; });
  StreamRig rig{stream_options(), config};
  engage(rig);
  expect_near_deg(rig.applied, expected_correction(real_arm(), rig.q), 2 * kWireDeg);
  rig.ticks(5000);
  expect_near_deg(rig.applied, expected_correction(real_arm(), rig.q), 2 * kWireDeg);
}

TEST(StreamCycle, RampsInAndOutOverTheControllersCyclesAndEndsAtExactlyZero) {
  StreamRig rig;
  rig.ticks(3);
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.tick();
  EXPECT_LT(rig.largest_applied_deg(), 1e-4) << "the first reply of a session";
  EXPECT_EQ(rig.state(), StreamState::RampingIn);
  rig.ticks(kRamp / 2 - 1);
  expect_near_deg(rig.applied, 0.5 * expected_correction(real_arm(), rig.q), 2 * kWireDeg);
  rig.ticks(kRamp / 2);
  EXPECT_EQ(rig.state(), StreamState::Active);

  rig.cycle->disengage();
  double last = rig.largest_applied_deg();
  for (int i = 0; i < kRamp - 1; ++i) {
    rig.tick();
    ASSERT_EQ(rig.state(), StreamState::RampingOut);
    ASSERT_LE(rig.largest_applied_deg(), last);
    last = rig.largest_applied_deg();
  }
  rig.tick();
  EXPECT_TRUE(rig.applied.isZero(0));
  EXPECT_EQ(rig.state(), StreamState::Idle);
}

TEST(StreamCycle, TurnsRoundInTheMiddleOfARamp) {
  StreamRig rig;
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(100);
  rig.cycle->disengage();
  rig.ticks(50);
  EXPECT_EQ(rig.state(), StreamState::RampingOut);
  rig.cycle->engage();
  rig.ticks(kRamp);
  expect_near_deg(rig.applied, expected_correction(real_arm(), rig.q), kWireDeg);
}

TEST(StreamCycle, LearnsTheStepOfIpocWhetherItCountsMillisecondsOrCycles) {
  for (const std::uint64_t step : {1u, 4u}) {
    StreamRig rig;
    rig.step = step;
    engage(rig);
    EXPECT_EQ(rig.status().ipoc_step, step);
  }
}

TEST(StreamCycle, KeepsTheTimeOfItsRampsAtTwelveMilliseconds) {
  config::CellConfig config;
  config.stream.cycle = std::chrono::milliseconds{12};
  StreamOptions options = StreamOptions::of(config);
  options.now = stream_options().now;
  StreamRig rig{options};
  rig.step = 12;
  rig.settle();
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(82);
  EXPECT_EQ(rig.state(), StreamState::RampingIn);
  rig.ticks(2);
  EXPECT_EQ(rig.state(), StreamState::Active) << "after a second, 83 cycles";
}

TEST(StreamCycle, RefusesToCorrectAtAnotherCycleThanItWasTold) {
  StreamRig rig;
  rig.step = 12;
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(100);
  EXPECT_EQ(rig.status().fault, StreamFault::WrongCycle);
  EXPECT_NE(reason(rig.status()).find("rises by 12 from packet to packet, but stream.cycle_ms is 4"),
            std::string::npos)
      << reason(rig.status());
  EXPECT_LT(rig.largest_applied_deg(), 0.001);
}

TEST(StreamCycle, CrossFadesFromOneModelToTheNextAndToNone) {
  StreamRig rig;
  engage(rig);
  const JointVector old_correction = expected_correction(real_arm(), rig.q);
  const JointVector new_correction = expected_correction(real_arm(-1.5), rig.q);
  rig.cycle->use_model(real_arm(-1.5), 2);
  rig.tick();
  expect_near_deg(rig.applied, old_correction, kWireDeg);
  EXPECT_EQ(rig.status().model, 2u);
  rig.ticks(kRamp / 2);
  expect_near_deg(rig.applied, 0.5 * (old_correction + new_correction), 2 * kWireDeg);
  rig.ticks(kRamp / 2);
  expect_near_deg(rig.applied, new_correction, kWireDeg);

  rig.cycle->use_no_model();
  rig.ticks(kRamp + 1);
  EXPECT_TRUE(rig.applied.isZero(0));
  EXPECT_EQ(rig.status().model, 0u);
}

TEST(StreamCycle, HoldsTheCorrectionThroughLostDatagramsAndCountsThem) {
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

TEST(StreamCycle, DoesNotMoveOnWhileTheControllerDoesNotTakeItsReplies) {
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

TEST(StreamCycle, HoldsOnAFrameThatItCannotBelieve) {
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

TEST(StreamCycle, DoesNotAnswerWithoutAReadableIpoc) {
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

TEST(StreamCycle, GivesARepeatedIpocTheSameReply) {
  StreamRig rig;
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(50);
  const std::string reply = rig.tick();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(rig.send(rig.datagram()), reply);
  EXPECT_EQ(rig.status().counters.duplicate, 3u);
}

TEST(StreamCycle, DoesNotAnswerAnIpocThatComesTooLate) {
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

TEST(StreamCycle, BeginsAtZeroAndRampsInAgainWhenTheControllerStartsAnew) {
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

TEST(StreamCycle, KnowsByTheAxesThatTheControllerBeganAnewAfterAShortSilence) {
  StreamRig rig;
  engage(rig, real_arm(4));
  rig.restart(rig.ipoc + 4 * 50);
  rig.ticks(5);
  EXPECT_EQ(rig.state(), StreamState::RampingIn);
  EXPECT_LT(rig.largest_applied_deg(), 0.001);
}

TEST(StreamCycle, KnowsByTheCountOfMissedRepliesThatTheControllerBeganAnewWhereTheAxesCannotTell) {
  rsi::EthernetConfig config = ethernet_config();
  std::erase_if(config.send, [](const rsi::Element& element) { return element.tag == "DEF_ASPos"; });
  StreamRig rig{stream_options(), config};
  engage(rig, real_arm(4));
  rig.restart(rig.ipoc + 4 * 50);
  rig.ticks(2);
  EXPECT_EQ(rig.state(), StreamState::RampingIn);
  EXPECT_LT(rig.largest_applied_deg(), 0.001);
}

TEST(StreamCycle, GoesOnAtOnceAfterAGapInWhichTheControllerCountedEveryCycle) {
  StreamRig rig;
  engage(rig, real_arm(4));
  const JointVector before = rig.applied;
  for (int lost = 0; lost < 60; ++lost) {
    rig.q[0] += 0.8 * kRadPerDeg;  // 200 deg/s: the axes could not tell
    rig.tick({.datagram_lost = true});
  }
  EXPECT_FALSE(rig.tick().empty());
  EXPECT_NE(before, JointVector(JointVector::Zero(6)));
  EXPECT_EQ(rig.status().counters.unproven, 3u);
}

TEST(StreamCycle, IsSilentToTheNearlyEmptyFirstFrameOfOldControllersAndThenRampsIn) {
  StreamRig rig;
  engage(rig);
  rig.restart(100);
  EXPECT_EQ(rig.tick({.replaced_by = "<Rob Type=\"KUKA\"><IPOC>104</IPOC></Rob>"}), "");
  rig.ticks(kRamp + 10);
  expect_near_deg(rig.applied, expected_correction(real_arm(), rig.q), kWireDeg);
}

TEST(StreamCycle, IsNotDeceivedByOneDamagedTimeStamp) {
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

TEST(StreamCycle, KeepsItsCorrectionWhereAThirtyTwoBitIpocIsFull) {
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

TEST(StreamCycle, HoldsOnCommandedAxesThatTheArmCannotHaveReached) {
  StreamRig rig;
  engage(rig);
  const JointVector before = rig.applied;
  const JointVector q = rig.q;
  rig.q[0] += 90 * kRadPerDeg;
  rig.ticks(3);
  EXPECT_EQ(rig.applied, before);
  rig.q = q;
  rig.ticks(3);
  EXPECT_EQ(rig.applied, before);
  EXPECT_EQ(rig.status().counters.held, 3u);
}

TEST(StreamCycle, HoldsWhereTheModelHasNoSolutionAndFadesBackWhenItHas) {
  StreamRig rig;
  engage(rig);
  const JointVector before = rig.applied;
  RobotModel broken = real_arm();
  broken.joints[2].a_mm = std::numeric_limits<double>::quiet_NaN();
  rig.cycle->use_model(broken, 2);
  rig.ticks(100);
  EXPECT_EQ(rig.applied, before);
  EXPECT_EQ(rig.status().counters.no_solution, 100u);
  rig.cycle->use_model(real_arm(-1), 3);
  rig.ticks(kRamp + 1);
  expect_near_deg(rig.applied, expected_correction(real_arm(-1), rig.q), kWireDeg);

  rig.cycle->use_model(broken, 4);
  rig.ticks(300);
  EXPECT_EQ(rig.status().fault, StreamFault::NoSolution);
  EXPECT_TRUE(rig.stop);
}

TEST(StreamCycle, ComesToZeroEvenWhereTheModelHasNoSolution) {
  StreamRig rig;
  engage(rig);
  RobotModel broken = real_arm();
  broken.joints[2].a_mm = std::numeric_limits<double>::quiet_NaN();
  rig.cycle->use_model(broken, 2);
  rig.ticks(10);
  rig.cycle->disengage();
  rig.ticks(kRamp + 2);
  EXPECT_TRUE(rig.applied.isZero(0));
  EXPECT_EQ(rig.state(), StreamState::Idle);
}

TEST(StreamCycle, CountsTheCyclesInWhichAJointLimitHeldTheCorrectionBack) {
  int held_back = 0;
  for (const double end_deg : {-184.99, 184.99}) {
    StreamRig rig;
    rig.q[0] = end_deg * kRadPerDeg;
    rig.settle();
    rig.cycle->use_model(real_arm(3), 1);
    rig.cycle->engage();
    rig.ticks(kRamp + 2);
    EXPECT_LE(std::abs(rig.q[0] + rig.applied[0]), 185 * kRadPerDeg);
    held_back += rig.status().counters.clamped_limit > 0;
  }
  EXPECT_EQ(held_back, 1) << "the correction of axis 1 leads out of its range at one of its ends";
}

TEST(StreamCycle, FaultsHoldsAndAsksToStopWhenABoundIsBrokenForLong) {
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

TEST(StreamCycle, AsksToLeaveRsiOnceNothingIsInForceAndAgainAfterEachReplyThatIsLost) {
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

TEST(StreamCycle, FreezesWhenTheAxesDoNotFollowAndGoesOnWhenAcknowledged) {
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

TEST(StreamCycle, IsNotFrozenByAnArmThatTrailsItsCommandInMotion) {
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

TEST(StreamCycle, SaysThatTheControllerRejectsRepliesThatWereSentInTime) {
  StreamRig rig;
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  for (int i = 0; i < 20; ++i) rig.tick({.rejected = true});
  EXPECT_EQ(rig.status().fault, StreamFault::RepliesRejected);
  EXPECT_NE(reason(rig.status()).find("SENTYPE"), std::string::npos);
  EXPECT_TRUE(rig.applied.isZero(0));
}

TEST(StreamCycle, BlamesNoControllerThatTookRepliesForABurstThatTheNetworkLost) {
  StreamRig rig;
  engage(rig);
  for (int i = 0; i < 60; ++i) rig.tick({.reply_lost = true});
  EXPECT_EQ(rig.status().fault, StreamFault::None);
  rig.ticks(2 * kRamp);
  EXPECT_EQ(rig.state(), StreamState::Active);
}

TEST(StreamCycle, PutsABacklogOfLateRepliesDownToNobodyAndResumesWithoutAJump) {
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

/// How far (mm) the point of the real arm is from where the nominal arm would have it.
double off_mm(const StreamRig& rig, const RobotModel& real, const Eigen::Vector3d& p_F_mm) {
  return (forward_kinematics(real, rig.q + rig.applied) * p_F_mm -
          forward_kinematics(nominal_arm(), rig.q) * p_F_mm)
      .norm();
}

TEST(StreamCycle, PassesAStretchedWristWithTheTcpInPlaceAndWithoutAJump) {
  const RobotModel real = with_published_errors(nominal_arm());
  const Eigen::Vector3d p_F_mm{120, -40, 300};
  StreamRig rig;
  rig.q = axes_deg({20, -80, 100, 30, 10, -40});
  rig.cycle->use_model(real, 1, p_F_mm);
  rig.cycle->engage();
  rig.ticks(kRamp + 2);
  const StreamStatus before = rig.status();
  for (int i = 0; i < 1000; ++i) {
    const JointVector last = rig.applied;
    rig.q[4] -= 0.02 * kRadPerDeg;
    rig.tick();
    ASSERT_LT(off_mm(rig, real, p_F_mm), 2e-4) << "six decimals on the wire; A5 = " << rig.q[4] * kDegPerRad;
    ASSERT_LT((rig.applied - last).cwiseAbs().maxCoeff() * kDegPerRad, 0.002);
    ASSERT_LT(rig.largest_applied_deg(), 0.5);
  }
  EXPECT_EQ(rig.state(), StreamState::Active) << reason(rig.status());
  EXPECT_EQ(rig.status().counters.damped - before.counters.damped, 1000u);
  EXPECT_EQ(rig.status().counters.clamped_step, before.counters.clamped_step);
}

TEST(StreamCycle, DampsNothingWhereTheCellSaysNever) {
  StreamOptions options = stream_options();
  options.singular_below_rad = 0;
  StreamRig rig{options};
  rig.q[4] = 5 * kRadPerDeg;
  engage(rig);
  EXPECT_EQ(rig.status().counters.damped, 0u);
}

TEST(StreamCycle, HoldsWhereOnlyASingularityAsksForALargeCorrectionAndGoesOnBeyond) {
  StreamOptions options = stream_options();
  options.max_total_rad = 20 * kRadPerDeg;
  options.broken_cycles = 1'000'000;
  StreamRig rig{options};
  const RobotModel real = with_published_errors(nominal_arm());
  rig.q = axes_deg({20, -130, 60, 30, 45, -40});  // the wrist's centre comes near axis 1
  engage(rig, real);
  for (int i = 0; i < 2000; ++i) {
    const JointVector last = rig.applied;
    const std::uint64_t unsolved = rig.status().counters.no_solution;
    rig.q[2] += 0.005 * kRadPerDeg;
    rig.tick();
    if (rig.status().counters.no_solution > unsolved) {
      ASSERT_EQ(rig.applied, last);
    }
    ASSERT_LE(rig.largest_applied_deg(), 10);
  }
  EXPECT_GT(rig.status().counters.no_solution, 100u);
  rig.ticks(1000);
  expect_near_deg(rig.applied, expected_correction(real, rig.q), kWireDeg);

  options.broken_cycles = stream_options().broken_cycles;
  StreamRig standing{options};
  standing.q = axes_deg({20, -130, 64.8, 30, 45, -40});
  standing.cycle->use_model(real, 1);
  standing.cycle->engage();
  standing.ticks(2 * kRamp);
  EXPECT_EQ(standing.status().fault, StreamFault::NoSolution);
  EXPECT_TRUE(standing.stop);
}

TEST(StreamCycle, LeadsANearlyStretchedArmNoFurtherOffThanItWasWhereTheTotalIsTooSmall) {
  const RobotModel real = with_published_errors(nominal_arm());
  StreamOptions options = stream_options();
  options.max_total_rad = 1.5 * kRadPerDeg;
  StreamRig rig{options};
  rig.q = axes_deg({20, -60, 5, 30, 45, -40});  // wants 1.46 deg of axis 2 and -3.45 of axis 3
  const double uncorrected_mm = off_mm(rig, real, {0, 0, 0});
  rig.cycle->use_model(real, 1);
  rig.cycle->engage();
  for (int i = 0; i < 2 * kRamp; ++i) {
    rig.tick();
    ASSERT_LT(off_mm(rig, real, {0, 0, 0}), uncorrected_mm + 1e-3);
  }
  EXPECT_EQ(rig.status().fault, StreamFault::BoundBroken);
}

TEST(StreamCycle, StreamsAtAStretchedWristForAsLongAsTheArmStandsThere) {
  StreamRig rig;
  rig.q[4] = 0;
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(1000);
  EXPECT_EQ(rig.state(), StreamState::Active) << reason(rig.status());
}

TEST(StreamCycle, TellsTheTurnaroundOfItsRepliesFromTheComputingOfThem) {
  StreamRig rig;
  rig.settle();
  rig.woken = 60us;
  rig.computed = 20us;
  rig.ticks(10);
  EXPECT_EQ(rig.cycle->turnaround().count, 11u) << "with the last of those that settle it";
  EXPECT_EQ(rig.cycle->turnaround().max_us, 80);
  EXPECT_EQ(rig.cycle->compute().count, 11u);
  EXPECT_EQ(rig.cycle->compute().max_us, 20);
}

TEST(StreamCycle, CountsWhomALateReplyIsDownTo) {
  StreamRig rig;
  rig.ticks(10);
  rig.computed = 2100us;
  rig.tick();
  rig.computed = 20us;
  rig.woken = 2100us;
  rig.ticks(2);
  rig.woken = 50us;
  rig.pass(2100us);
  rig.tick();
  const StreamCounters counters = rig.status().counters;
  EXPECT_EQ(counters.late_by_us, 1u);
  EXPECT_EQ(counters.late_by_machine, 2u);
  EXPECT_EQ(counters.late_by_network, 1u);
}

StreamRig rig_with(const RobotModel& model) {
  StreamRig rig;
  rig.cycle->use_model(model, 1);
  rig.cycle->engage();
  return rig;
}

/// Good, lost, repeated and damaged datagrams of an arm that moves through its wrist singularity.
void move_in_trouble(StreamRig& rig) {
  rig.settle();
  for (int i = 1; i <= 900; ++i) {
    rig.q[4] -= 0.08 * kRadPerDeg;
    const bool damaged = i % 90 == 0;
    rig.tick({.datagram_lost = i % 50 == 0,
              .reply_lost = i % 70 == 0,
              .replaced_by = damaged ? "<Rob><IPOC>" + std::to_string(rig.ipoc + rig.step) + "</IPOC>" : ""});
    if (i % 60 == 0) rig.send(rig.datagram());
    if (i % 80 == 0) rig.send("garbage");
  }
}

class TheGuardedStream : public testing::TestWithParam<RegressorKind> {};

TEST_P(TheGuardedStream, NeverAllocatesLocksOrCallsTheSystemWhateverArrives) {
  const RobotModel model = heavy_arm(GetParam());
  StreamRig before = rig_with(model);
  move_in_trouble(before);
  StreamRig rig = rig_with(model);
  const auto answer_all = [&] {
    for (const auto& [bytes, now] : before.sent) {
      const bool replied = !rig.cycle->answer({bytes, rig.source, now}).empty();
      rig.cycle->finish({.received = now, .taken = now, .ready = now, .sent = now, .replied = replied});
    }
  };
  EXPECT_TRUE(TRUEPOSE_SANITIZED || makes_no_system_call(answer_all));
  const auto calls_before = std::pair{allocations(), locks()};
  answer_all();
  EXPECT_EQ(std::pair(allocations(), locks()), calls_before);
  EXPECT_EQ(rig.state(), StreamState::Active);
  EXPECT_GT(rig.status().counters.answered, 700u);
  EXPECT_GT(rig.status().counters.damped, 50u);
}

INSTANTIATE_TEST_SUITE_P(WithEveryField, TheGuardedStream, testing::ValuesIn(kAllRegressors),
                         [](const auto& kind) { return std::string{name_of(kind.param)}; });

TEST(StreamCycle, IsRefusedWithAConfigurationThatCannotCarryCorrections) {
  const auto refused = [](const rsi::EthernetConfig& config, const RobotModel& robot,
                          const StreamOptions& options) {
    const auto cycle = StreamCycle::create(robot, config, options);
    return !cycle && !cycle.error().empty();
  };
  EXPECT_FALSE(refused(ethernet_config(), nominal_arm(), stream_options()));
  rsi::EthernetConfig config = ethernet_config();
  config.only_send = true;
  EXPECT_TRUE(refused(config, nominal_arm(), stream_options()));
  config = ethernet_config();
  config.axis_correction.reset();
  EXPECT_TRUE(refused(config, nominal_arm(), stream_options()));
  config = ethernet_config();
  config.send.clear();
  EXPECT_TRUE(refused(config, nominal_arm(), stream_options()));
  config = ethernet_config();
  std::erase_if(config.send, [](const rsi::Element& element) { return element.tag == "DEF_Delay"; });
  EXPECT_TRUE(refused(config, nominal_arm(), stream_options())) << "no reply could be known to be taken";
  config = ethernet_config();
  for (rsi::Element& element : config.receive) element.hold_on &= element.tag != "AK.A4";
  EXPECT_TRUE(refused(config, nominal_arm(), stream_options())) << "a lost packet would be a jump of axis 4";
  RobotModel five = nominal_arm();
  five.joints.pop_back();
  EXPECT_TRUE(refused(ethernet_config(), five, stream_options()));
  StreamOptions options = stream_options();
  options.max_step_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused(ethernet_config(), nominal_arm(), options));
}

}  // namespace
}  // namespace truepose::daemon
