#include "daemon/realtime/stream_cycle.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/arm/forward.hpp"
#include "tests/allocations.hpp"
#include "tests/daemon/engaged_stream.hpp"
#include "tests/daemon/heavy_model.hpp"
#include "tests/sanitized.hpp"
#include "tests/system_calls.hpp"

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;

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
  EXPECT_EQ(status.counters.unconfirmed, 3u) << "the first cycles show that nothing is in force";
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
  StreamRig rig{StreamOptions::of(config)};
  rig.step = 12;
  rig.settle();
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(82);
  EXPECT_EQ(rig.state(), StreamState::RampingIn);
  rig.ticks(2);
  EXPECT_EQ(rig.state(), StreamState::Active) << "after a second, 83 cycles";
}

TEST(StreamCycle, RefusesToCorrectAtAnotherCycleThanConfigured) {
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

TEST(StreamCycle, NamesTwoSendersOfOneAddressWhoseCyclesDoNotFit) {
  StreamRig rig;
  engage(rig);
  const std::uint64_t lost = rig.status().counters.lost;
  for (int silent = 0; silent < 12; ++silent) rig.tick({.datagram_lost = true});
  rig.source.port = 50'000;
  rig.step = 12;
  rig.ticks(20);
  EXPECT_EQ(rig.status().fault, StreamFault::WrongCycle);
  EXPECT_NE(reason(rig.status()).find("sent from port 40000, and within a second from port 50000"),
            std::string::npos)
      << reason(rig.status());
  EXPECT_LE(rig.status().counters.lost - lost, 12U);
}

TEST(StreamCycle, CountsNoDatagramsAsLostThatACountWhichJumpsSkips) {
  StreamRig rig;
  engage(rig);
  rig.ipoc += 10'000'000'000;
  rig.ticks(20);
  EXPECT_LE(rig.status().counters.lost, 200U);
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
  EXPECT_EQ(counters.late_by_daemon, 1u);
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

TEST(TheGuardedStream, NeverAllocatesLocksOrCallsTheSystemWhateverArrives) {
  const RobotModel model = heavy_arm();
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
