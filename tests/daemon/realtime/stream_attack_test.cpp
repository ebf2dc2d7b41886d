#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "core/arm/forward.hpp"
#include "daemon/realtime/stream_status.hpp"
#include "tests/daemon/corrected_stream.hpp"

// What broke the stream in attacks on the whole product, each as a sentence about what holds now. The rig
// fails a test on any reply that the controller takes and that moves an axis by more than a step.
namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

std::vector<std::string> events_of(StreamCycle& cycle, StreamEventKind kind) {
  std::vector<std::string> lines;
  for (StreamEvent event; cycle.next_event(event);) {
    if (event.kind == kind) lines.push_back(describe(event));
  }
  return lines;
}

StreamOptions pinned_options() {
  StreamOptions options = stream_options();
  options.peer = 0x7f000001;
  return options;
}

TEST(AStreamUnderAttack, IsNotLedAnywhereByTwoForgedDatagramsOfAnotherAddress) {
  StreamRig rig{pinned_options()};
  correct(rig);
  ASSERT_GT(rig.largest_applied_deg(), 1);
  const JointVector before = rig.applied;
  StreamRig forger;
  forger.ipoc = 1'000'000'000'000;
  for (int i = 0; i < 2; ++i) {
    forger.ipoc += 4;
    EXPECT_EQ(rig.send(forger.datagram(), {0x7f000002, 40'000}), "");
  }
  rig.ticks(10);
  EXPECT_EQ(rig.applied, before);
  EXPECT_EQ(rig.status().counters.unexpected_sender, 2u);
  EXPECT_EQ(rig.status().counters.sessions, 1u);
  EXPECT_THAT(events_of(*rig.cycle, StreamEventKind::Foreign),
              testing::ElementsAre(HasSubstr("packets of 127.0.0.2:40000 are dropped")))
      << "named once";
}

TEST(AStreamUnderAttack, DoesNotFollowABurstThatKnowsTheTimeStampsButComesFromAnotherPort) {
  StreamRig rig{pinned_options()};
  correct(rig);
  const JointVector before = rig.applied;
  StreamRig forger;
  forger.ipoc = rig.ipoc;
  for (int i = 0; i < 90; ++i) {
    forger.ipoc += 4;
    forger.q[3] += 0.5 * kRadPerDeg;
    EXPECT_EQ(rig.send(forger.datagram(), {rig.source.address, 40'001}), "");
  }
  rig.tick();
  EXPECT_EQ(rig.applied, before);
  EXPECT_EQ(rig.status().counters.datagrams + 0u, 4u + kRampCycles + 2u + 1u)
      << "foreign datagrams are in no other figure";
}

TEST(AStreamUnderAttack, AnswersTheControllerOnItsNewPortOnceTheOldOneIsSilent) {
  StreamRig rig{pinned_options()};
  correct(rig);
  rig.restart(rig.ipoc + 400);
  rig.source.port = 50'123;
  rig.ticks(6);
  EXPECT_EQ(rig.state(), StreamState::RampingIn);
  EXPECT_EQ(rig.status().peer->port, 50'123);
}

TEST(AStreamUnderAttack, ChangesNothingByMoreThanAStepForThousandsOfStrangers) {
  StreamRig rig{pinned_options()};
  correct(rig);
  for (std::uint32_t i = 0; i < 5000; ++i) rig.send(rig.datagram(), {0x0a000000 + i, 1});
  rig.ticks(5);
  EXPECT_EQ(rig.state(), StreamState::Active);
  EXPECT_LE(events_of(*rig.cycle, StreamEventKind::Foreign).size(), 8u) << "who floods does not fill the log";
}

TEST(AStreamUnderAttack, KeepsItsCorrectionOverALinkThatFlapsWhileTheArmLagsByExactlyThat) {
  StreamRig rig;
  correct(rig);
  // The arm trails by what is corrected: AIPos is at ASPos, as after a new start.
  rig.stuck = rig.q;
  for (int lost = 0; lost < 12; ++lost) rig.tick({.datagram_lost = true});
  rig.ticks(20);
  EXPECT_GT(rig.largest_applied_deg(), 1);
}

TEST(AStreamUnderAttack, KeepsItsCorrectionOverAGapLongerThanItsTimeout) {
  StreamRig rig;  // timeout_cycles 100; the controller's may be longer
  correct(rig);
  for (int lost = 0; lost < 137; ++lost) rig.tick({.datagram_lost = true});
  rig.ticks(20);
  EXPECT_GT(rig.largest_applied_deg(), 1);
  EXPECT_EQ(rig.status().counters.sessions, 1u);
}

TEST(AStreamUnderAttack, IsNotFrozenByAnArmThatStandsElsewhereOnceNothingIsToBeCorrected) {
  StreamRig rig;
  correct(rig);
  rig.stuck = rig.q + rig.applied;
  rig.cycle->disengage();
  rig.ticks(4 * kRampCycles);
  EXPECT_EQ(rig.state(), StreamState::Idle);
  EXPECT_TRUE(rig.applied.isZero(0));
}

TEST(AStreamUnderAttack, TakesAnAcknowledgementOfAControllerThatSendsNothingAnyMore) {
  StreamRig rig;
  correct(rig);
  rig.stuck = rig.q;
  rig.ticks(1000);
  ASSERT_EQ(rig.state(), StreamState::Frozen);
  rig.cycle->acknowledge();
  rig.cycle->on_no_datagram(drivers::TimePoint{});
  EXPECT_EQ(rig.status().fault, StreamFault::None);
  EXPECT_NE(rig.state(), StreamState::Frozen);
}

TEST(AStreamUnderAttack, ShowsNoMeasuredCorrectionOfASessionThatIsOver) {
  StreamRig rig;
  correct(rig);
  rig.ticks(500);
  ASSERT_TRUE(rig.status().measured_deg[0]);
  rig.restart(rig.ipoc + 4'000);
  rig.ticks(50);
  EXPECT_FALSE(rig.status().measured_deg[0]);
}

/// For half a second, of which the controller counts every cycle.
void fall_silent(StreamRig& rig) {
  constexpr int kCycles = 125;
  rig.pass(500ms);
  rig.ipoc += 4 * kCycles;
  rig.delay += kCycles;
}

TEST(AStreamUnderAttack, MustBeRestartedAfterTheControllerStoppedSending) {
  StreamRig rig;
  correct(rig);
  fall_silent(rig);
  rig.ticks(2 * kRampCycles);
  EXPECT_EQ(rig.state(), StreamState::Idle);
  EXPECT_TRUE(rig.applied.isZero(0));
  EXPECT_THAT(events_of(*rig.cycle, StreamEventKind::Disarmed),
              testing::ElementsAre(HasSubstr("started again")));
  rig.cycle->engage();
  rig.ticks(kRampCycles + 2);
  EXPECT_EQ(rig.state(), StreamState::Active);
}

TEST(AStreamUnderAttack, GoesOnByItselfAfterASilenceWhereTheCellSaysSo) {
  StreamOptions options = stream_options();
  options.disarm_after.reset();
  StreamRig rig{options};
  correct(rig);
  fall_silent(rig);
  rig.ticks(2 * kRampCycles);
  EXPECT_EQ(rig.state(), StreamState::Active);
  EXPECT_GT(rig.largest_applied_deg(), 1);
}

TEST(AStreamUnderAttack, CorrectsNoOtherArmThanTheRobotFileDescribes) {
  StreamRig rig;
  rsi::CartesianPose rist;
  const auto pose_of = [&](const RobotModel& arm) {
    const Eigen::Vector3d p_BF_mm = forward_kinematics(arm, rig.q).translation();
    rist = {p_BF_mm.x(), p_BF_mm.y(), p_BF_mm.z(), 0, 0, 0};
  };
  pose_of(nominal_arm());
  rig.rist = rist;
  rig.ticks(500);
  EXPECT_EQ(rig.status().fault, StreamFault::None);
  RobotModel longer = nominal_arm();
  longer.joints[2].a_mm += 200;
  pose_of(longer);
  rig.rist = rist;
  rig.cycle->use_model(kFarOff, 1);
  rig.cycle->engage();
  rig.ticks(260);
  EXPECT_EQ(rig.status().fault, StreamFault::WrongArm);
  EXPECT_THAT(reason(rig.status()), HasSubstr("mm from where the robot file's arm has its flange"));
}

TEST(AStreamUnderAttack, SaysWhatTheControllerDoesNotSendThoughItsConfigurationDoes) {
  const auto fault_without = [](const std::string& element, const rsi::EthernetConfig& config) {
    StreamRig rig{stream_options(), config};
    rig.sends_delay = element != "Delay";
    rig.sends_aipos = element != "AIPos";
    rig.ticks(40);
    rig.cycle->use_model(kFarOff, 1);
    rig.cycle->engage();
    rig.ticks(300);
    EXPECT_EQ(rig.status().fault, StreamFault::NotSent) << element;
    return reason(rig.status());
  };
  for (const std::string element : {"Delay", "AIPos"}) {
    EXPECT_THAT(fault_without(element, ethernet_config()),
                testing::AllOf(HasSubstr("have no " + element), HasSubstr("which sends DEF_" + element)));
  }
  EXPECT_THAT(fault_without("RIst", shipped_ethernet_config()), HasSubstr("have no RIst"));
}

TEST(AStreamUnderAttack, DoesWithoutWhatItsConfigurationDoesNotSend) {
  rsi::EthernetConfig config = ethernet_config();
  std::erase_if(config.send, [](const rsi::Element& element) { return element.tag == "DEF_AIPos"; });
  StreamRig rig{stream_options(), config};
  rig.sends_aipos = false;
  rig.ticks(40);
  rig.cycle->use_model(kFarOff, 1);
  rig.cycle->engage();
  rig.ticks(600);
  EXPECT_EQ(rig.status().fault, StreamFault::None) << reason(rig.status());
}

TEST(AStreamUnderAttack, NamesAnotherCycleOfAFastArmBeforeItKnowsWhatIsInForce) {
  StreamRig rig;  // of 4 ms
  rig.step = 12;
  const JointVector start = rig.q;
  JointVector actual = rig.q;
  int cycles = 0;
  for (; cycles < 400 && rig.state() != StreamState::Fault; ++cycles) {
    const double t = 0.012 * cycles;
    rig.q = start;
    rig.q[3] += 80 * kRadPerDeg * (1 - std::cos(2.5 * t));
    rig.q[5] += 70 * kRadPerDeg * std::sin(3 * t);
    actual += (rig.q - actual) / 9;
    rig.stuck = actual;
    rig.tick();
  }
  EXPECT_LE(cycles, 10) << name(rig.state());
  EXPECT_THAT(reason(rig.status()), HasSubstr("IPOC rises by 12"));
}

TEST(AStreamUnderAttack, ShowsTheFirstFrameOfASessionThatItDidNotUnderstand) {
  StreamRig rig;
  rig.settle();
  rig.send("<Rob Type=\"KUKA\"><ASPos A1=\"1\"/><IPOC>" + std::to_string(rig.ipoc + 4) + "</IPOC></Rob>");
  EXPECT_THAT(
      events_of(*rig.cycle, StreamEventKind::Malformed),
      testing::ElementsAre(testing::AllOf(HasSubstr("127.0.0.1:40000"), HasSubstr("ASPos.A2 is missing"),
                                          HasSubstr("it begins `<Rob Type=\"KUKA\"><ASPos A1=\"1\"/>"))));
}

TEST(AStreamUnderAttack, ShowsWhatIsNotUnderstoodAgainAfterAPause) {
  StreamRig rig;
  const auto malformed_events_of = [&rig](const std::string& bytes) {
    rig.send(bytes);
    return events_of(*rig.cycle, StreamEventKind::Malformed);
  };
  EXPECT_THAT(malformed_events_of("<Rob><IPOC>4</IPOC></Rob>"),
              testing::ElementsAre(HasSubstr("ASPos is missing; it")));
  EXPECT_THAT(malformed_events_of("<Rob><IPOC>8</IPOC></Rob>"), testing::IsEmpty());
  rig.pass(2s);  // somebody loads another configuration, and another wrong one
  EXPECT_THAT(malformed_events_of("<Rab><IPOC>12</IPOC></Rab>"),
              testing::ElementsAre(HasSubstr("not of the kind <Rob>")));
}

TEST(AStreamUnderAttack, ShowsThePlaceOfAnElementThatItCannotReadAndGoesOnWithoutIt) {
  StreamRig rig;
  rig.settle();
  rig.ipoc += 4;
  std::string bad = rig.datagram();
  bad.replace(bad.find(" A6=", bad.find("<AIPos")), 4, " B6=");
  EXPECT_NE(rig.send(bad), "");
  EXPECT_EQ(rig.status().counters.partly_read, 1u);
  EXPECT_THAT(events_of(*rig.cycle, StreamEventKind::PartlyRead),
              testing::ElementsAre(testing::AllOf(HasSubstr("can be read in part alone"),
                                                  HasSubstr("AIPos.A6 is missing (at byte"),
                                                  HasSubstr("there it reads `"), HasSubstr(" B6="))));
}

}  // namespace
}  // namespace truepose::daemon
