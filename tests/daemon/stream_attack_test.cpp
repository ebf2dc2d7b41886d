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
#include "tests/daemon/stream_rig.hpp"

// What broke the stream in attacks on the whole product, each as a sentence about what holds now. The rig
// fails a test on any reply that the controller takes and that moves an axis by more than a step.
namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr int kRampCycles = 250;
const RobotModel kFarOff = real_arm(20);  // corrections of more than a degree

void correct(StreamRig& rig, const RobotModel& arm = kFarOff) {
  rig.settle();
  rig.cycle->use_model(arm, 1);
  rig.cycle->engage();
  rig.ticks(kRampCycles + 2);
  ASSERT_EQ(rig.state(), StreamState::Active) << reason(rig.status());
}

std::vector<std::string> told(StreamCycle& cycle, StreamEventKind kind) {
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
  EXPECT_EQ(rig.status().counters.foreign, 2u);
  EXPECT_EQ(rig.status().counters.sessions, 1u);
  EXPECT_THAT(told(*rig.cycle, StreamEventKind::Foreign),
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
  EXPECT_LE(told(*rig.cycle, StreamEventKind::Foreign).size(), 8u) << "who floods does not fill the log";
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

TEST(AStreamUnderAttack, KeepsItsCorrectionOverAGapLongerThanTheTimeoutThatItWasTold) {
  StreamRig rig;  // timeout_cycles 100; the controller's may be longer
  correct(rig);
  for (int lost = 0; lost < 137; ++lost) rig.tick({.datagram_lost = true});
  rig.ticks(20);
  EXPECT_GT(rig.largest_applied_deg(), 1);
  EXPECT_EQ(rig.status().counters.sessions, 1u);
}

/// A page under another name for each test.
class ARestartedStream : public testing::Test {
 protected:
  ARestartedStream()
      : file_{std::filesystem::path{testing::TempDir()} /
              ("stream-" + std::to_string(::getpid()) + "-" +
               testing::UnitTest::GetInstance()->current_test_info()->name())},
        memory_{StreamMemory::open(file_).value()} {}
  ~ARestartedStream() override { std::filesystem::remove(file_); }

  /// A new process takes the place of the rig's.
  void restart(StreamRig& rig, StreamMemory* memory) {
    rig.cycle = StreamCycle::create(nominal_arm(), ethernet_config(), stream_options(), memory).value();
  }

  std::filesystem::path file_;
  std::unique_ptr<StreamMemory> memory_;
};

TEST_F(ARestartedStream, GoesOnFromTheCorrectionThatTheProcessBeforeItLeft) {
  StreamRig rig;
  restart(rig, memory_.get());
  correct(rig);
  const JointVector before = rig.applied;
  memory_ = StreamMemory::open(file_).value();
  for (int down = 0; down < 16; ++down) rig.tick({.datagram_lost = true});  // 65 ms
  restart(rig, memory_.get());
  rig.tick();
  EXPECT_EQ(rig.applied, before) << "held in the first cycle";
  EXPECT_EQ(rig.state(), StreamState::RampingOut) << "nobody has started the stream of this process";
  rig.ticks(2 * kRampCycles);
  EXPECT_TRUE(rig.applied.isZero(0));
}

TEST_F(ARestartedStream, AdoptsWhatIsInForceWhereNothingWasLeftAndTheArmStands) {
  StreamRig rig;
  correct(rig);
  restart(rig, nullptr);
  rig.ticks(10);
  EXPECT_GT(rig.largest_applied_deg(), 1) << "not answered";
  EXPECT_EQ(rig.state(), StreamState::Unproven);
  EXPECT_THAT(reason(rig.status()), HasSubstr("as soon as the arm stands"));
  rig.ticks(2 * kRampCycles);
  EXPECT_TRUE(rig.applied.isZero(0)) << "ramped out, a step at a time";
}

TEST_F(ARestartedStream, StaysSilentWhileTheArmMovesAndNothingIsKnown) {
  StreamRig rig;
  correct(rig);
  restart(rig, nullptr);
  for (int i = 0; i < 100; ++i) {
    rig.q[0] += 0.4 * kRadPerDeg;
    EXPECT_EQ(rig.tick({.datagram_lost = i == 50}), "");
  }
  EXPECT_GT(rig.largest_applied_deg(), 1);
  EXPECT_EQ(rig.status().counters.lost, 1) << "told although nothing is answered";
}

TEST_F(ARestartedStream, DoesNotBelieveAPageThatIsNotWhole) {
  StreamRig rig;
  restart(rig, memory_.get());
  correct(rig);
  memory_.reset();
  std::filesystem::resize_file(file_, 40);
  memory_ = StreamMemory::open(file_).value();
  EXPECT_FALSE(memory_->last());
}

/// An arm at full speed, whose drives trail by a dead time and a lag, on a link that now and then loses
/// something.
struct MovingArm {
  double lag_cycles = 0;
  std::size_t dead_cycles = 0;
  double lag_swings_by = 0;     ///< share, up and down in 7 s
  double friction_deg = 0;      ///< so far an axis stays behind whatever its speed
  int leg_cycles = 0;           ///< A4 goes there and back by 480 deg in so many, evenly; else it swings
  int datagram_lost_every = 0;  ///< cycles; 0 = never
  int lost_in_a_row = 1;
  int reply_lost_every = 0;
  bool takes_corrections = true;

  void stand_at_start(StreamRig& rig) {
    rig.q =
        leg_cycles > 0 ? axes_deg({-144, -125, 60, -240, 110, 180}) : axes_deg({10, -80, 90, 20, 45, -30});
    start = actual = rig.q;
    given.assign(dead_cycles + 1, start);
    rig.settle();
  }
  void tick(StreamRig& rig, int cycle) {
    const JointVector before = rig.q;
    rig.q = leg_cycles > 0 ? JointVector{rig.q + next_step(cycle)} : swing(0.004 * cycle);
    given.push_back(takes_corrections ? JointVector{rig.q + rig.applied} : rig.q);
    const double lag = lag_cycles * (1 + lag_swings_by * std::sin(2 * std::numbers::pi * cycle * 0.004 / 7));
    actual += (given[given.size() - 1 - dead_cycles] - actual) / (1 + lag);
    rig.stuck = actual - friction_deg * kRadPerDeg * (rig.q - before).cwiseSign();
    const auto lost = [cycle](int every, int in_a_row) {
      return every > 0 && cycle % every >= every - in_a_row;
    };
    rig.tick(
        {.datagram_lost = lost(datagram_lost_every, lost_in_a_row), .reply_lost = lost(reply_lost_every, 1)});
  }
  /// An emergency stop: the set points end where they are, and the brakes hold the arm where that had come
  /// to.
  void be_held(StreamRig& rig, int cycles) {
    for (int i = 0; i < cycles; ++i) rig.tick();
  }
  /// The program has stopped.
  void stand(StreamRig& rig, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      actual += (rig.q + rig.applied - actual) / (1 + lag_cycles);
      rig.stuck = actual;
      rig.tick();
    }
  }

  JointVector swing(double t_s) const {
    const JointVector amplitude = axes_deg({60, -10, 15, 80, 10, 40});
    const std::array<double, 6> frequency{2, 1.7, 2.2, 2.5, 1.9, 3};  // A4 at 200 deg/s
    JointVector q = start;
    for (Eigen::Index i = 0; i < 6; ++i)
      q[i] += amplitude[i] * (1 - std::cos(frequency[static_cast<std::size_t>(i)] * t_s));
    return q;
  }
  JointVector next_step(int cycle) {
    const double deg_s = 480 / (0.004 * leg_cycles);  // begins and ends at 500 deg/s^2
    speed_deg_s += std::clamp((cycle / leg_cycles % 2 == 0 ? deg_s : -deg_s) - speed_deg_s, -2.0, 2.0);
    return 0.004 * speed_deg_s * axes_deg({0.6, 0.15, 0.18, 1, -0.15, -0.75});
  }

  JointVector start{}, actual{};
  std::vector<JointVector> given{};
  double speed_deg_s = 0;
};

const MovingArm kMovingArms[] = {
    {},
    {.lag_cycles = 10},
    {.lag_cycles = 25},
    {.dead_cycles = 7},
    {.lag_cycles = 8, .dead_cycles = 3},
    {.lag_cycles = 10, .lag_swings_by = 0.02},
    {.lag_cycles = 10, .friction_deg = 0.02},
    {.lag_cycles = 10, .datagram_lost_every = 40},
    {.lag_cycles = 10, .datagram_lost_every = 200, .lost_in_a_row = 6},
    {.lag_cycles = 10, .reply_lost_every = 40},
};

std::vector<MovingArm> moving_arms() {
  std::vector<MovingArm> arms;
  for (MovingArm arm : kMovingArms) {
    for (const int leg_cycles : {0, 600, 1500}) {  // at up to 200, at 200, at 80 deg/s
      arm.leg_cycles = leg_cycles;
      arms.push_back(arm);
    }
  }
  return arms;
}

std::string told(const MovingArm& arm) {
  std::ostringstream text;
  text << "legs of " << arm.leg_cycles << " cycles, " << arm.lag_cycles << " cycles of lag that swings by "
       << arm.lag_swings_by << ", " << arm.dead_cycles << " dead, friction " << arm.friction_deg << " deg, "
       << arm.lost_in_a_row << " datagrams lost in " << arm.datagram_lost_every << ", a reply in "
       << arm.reply_lost_every;
  return text.str();
}

TEST(AStreamUnderAttack, FindsWithinTwoSecondsThatItsCorrectionsDoNothingWhileTheArmMovesAtFullSpeed) {
  for (MovingArm arm : moving_arms()) {
    SCOPED_TRACE(told(arm));
    arm.takes_corrections = false;  // the names differ: nothing of the correction arrives
    StreamRig rig;
    arm.stand_at_start(rig);
    rig.cycle->use_model(kFarOff, 1);
    constexpr int kBefore = 750;  // in motion, so that the whole correction is sent in the middle of a leg
    for (int cycle = 0; cycle < kBefore; ++cycle) arm.tick(rig, cycle);
    rig.cycle->engage();
    int cycles = 0;
    for (; cycles < 5000 && rig.state() != StreamState::Frozen; ++cycles) arm.tick(rig, kBefore + cycles);
    EXPECT_LE(cycles, kRampCycles + 500) << "within 2 s of the whole correction";
    EXPECT_THAT(reason(rig.status()), HasSubstr("another name for the correction"));
    const FaultDetail detail = rig.status().detail;
    EXPECT_NEAR(detail.value, 0, detail.uncertain) << reason(rig.status());
    EXPECT_GT(std::abs(detail.value - detail.limit), detail.uncertain);
  }
}

TEST(AStreamUnderAttack, MeasuresTheCorrectionBesideTheOneThatItSendsAndAcceptsAnyLag) {
  for (MovingArm arm : moving_arms()) {
    SCOPED_TRACE(told(arm));
    StreamRig rig;
    arm.stand_at_start(rig);
    rig.cycle->use_model(kFarOff, 1);
    rig.cycle->engage();
    for (int cycle = 0; cycle < 8000; ++cycle) {
      arm.tick(rig, cycle);
      ASSERT_EQ(rig.status().fault, StreamFault::None) << reason(rig.status()) << " in cycle " << cycle;
    }
    arm.stand(rig, 1000);
    const StreamStatus status = rig.status();
    for (std::size_t i = 0; i < 6; ++i) {
      ASSERT_TRUE(status.measured_deg[i]);
      EXPECT_NEAR(*status.measured_deg[i], status.correction_deg[i], 0.002);
    }
  }
}

/// Of a controller that does not tell that its program is stopped.
TEST(AStreamUnderAttack, AccusesNoHealthyArmAfterAnEmergencyStopThatWasAcknowledged) {
  int frozen = 0;
  for (MovingArm arm : moving_arms()) {
    if (arm.lag_cycles + static_cast<double>(arm.dead_cycles) == 0) continue;  // it is nowhere else when held
    SCOPED_TRACE(told(arm));
    StreamRig rig;
    arm.stand_at_start(rig);
    rig.cycle->use_model(kFarOff, 1);
    rig.cycle->engage();
    int cycle = 0;
    const auto move = [&](int cycles) {
      for (const int end = cycle + cycles; cycle < end; ++cycle) {
        arm.tick(rig, cycle);
        ASSERT_EQ(rig.status().fault, StreamFault::None) << reason(rig.status()) << " in cycle " << cycle;
      }
    };
    for (int stop = 0; stop < 3; ++stop) {
      move(1500 + 170 * stop);
      if (testing::Test::HasFatalFailure()) return;
      arm.be_held(rig, 1500);
      frozen += rig.state() == StreamState::Frozen;
      rig.cycle->acknowledge();
    }
    move(3000);
  }
  EXPECT_GT(frozen, 60) << "of 81 stops";
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
  rig.cycle->nothing_came(drivers::TimePoint{});
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

TEST(AStreamUnderAttack, MustBeStartedAnewAfterTheControllerFellSilent) {
  StreamRig rig;
  correct(rig);
  fall_silent(rig);
  rig.ticks(2 * kRampCycles);
  EXPECT_EQ(rig.state(), StreamState::Idle);
  EXPECT_TRUE(rig.applied.isZero(0));
  EXPECT_THAT(told(*rig.cycle, StreamEventKind::Disarmed), testing::ElementsAre(HasSubstr("started anew")));
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
      told(*rig.cycle, StreamEventKind::Malformed),
      testing::ElementsAre(testing::AllOf(HasSubstr("127.0.0.1:40000"), HasSubstr("ASPos.A2 is missing"),
                                          HasSubstr("it begins `<Rob Type=\"KUKA\"><ASPos A1=\"1\"/>"))));
}

TEST(AStreamUnderAttack, ShowsWhatIsNotUnderstoodAnewAfterAPause) {
  StreamRig rig;
  const auto told_of = [&rig](const std::string& bytes) {
    rig.send(bytes);
    return told(*rig.cycle, StreamEventKind::Malformed);
  };
  EXPECT_THAT(told_of("<Rob><IPOC>4</IPOC></Rob>"), testing::ElementsAre(HasSubstr("ASPos is missing; it")));
  EXPECT_THAT(told_of("<Rob><IPOC>8</IPOC></Rob>"), testing::IsEmpty());
  rig.pass(2s);  // somebody loads another configuration, and another wrong one
  EXPECT_THAT(told_of("<Rab><IPOC>12</IPOC></Rab>"),
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
  EXPECT_THAT(told(*rig.cycle, StreamEventKind::PartlyRead),
              testing::ElementsAre(testing::AllOf(HasSubstr("can be read in part alone"),
                                                  HasSubstr("AIPos.A6 is missing (at byte"),
                                                  HasSubstr("there it reads `"), HasSubstr(" B6="))));
}

}  // namespace
}  // namespace truepose::daemon
