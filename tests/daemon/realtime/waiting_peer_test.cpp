// Simulators of the robot's side that send the next frame only after a reply, and the same one after a time:
// kuka_experimental (1 s, Delay counts timeouts), FZI's kuka_rsi_driver (1 s, no Delay that counts),
// kuka_drivers (40 ms, no ASPos). All count replies in their IPOC, from 0. Stand-ins by that description.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/daemon/corrected_stream.hpp"

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

StreamOptions fresh_cell() {
  StreamOptions options = stream_options();
  options.never_corrected = true;
  options.disarm_after.reset();
  return options;
}

StreamOptions next_process() {
  StreamOptions options = fresh_cell();
  options.never_corrected = false;
  return options;
}

rsi::EthernetConfig without_aspos() {
  rsi::EthernetConfig config = ethernet_config();
  std::erase_if(config.send, [](const rsi::Element& element) { return element.tag == "DEF_ASPos"; });
  return config;
}

/// Such a simulator in virtual time. The axes take up a correction at once, or never show it, as in a dead
/// time.
class WaitingSimulator {
 public:
  explicit WaitingSimulator(std::uint64_t first_ipoc = 0, std::chrono::milliseconds patience = 1s,
                            const StreamOptions& options = fresh_cell(),
                            const rsi::EthernetConfig& config = ethernet_config(),
                            StreamMemory* memory = nullptr)
      : rig{options, config, memory}, patience_{patience} {
    rig.ipoc = first_ipoc;
  }

  /// One frame. @return whether it was answered
  bool send(bool reply_is_lost = false) {
    const std::string reply = rig.send(rig.datagram());
    if (reply.empty() || reply_is_lost) {
      rig.pass(patience_);
      rig.delay += counts_timeouts;
      return false;
    }
    take(reply);
    rig.pass(2ms);
    return true;
  }
  /// @return how many of so many frames were answered
  int send(int frames) {
    int answered = 0;
    for (int i = 0; i < frames; ++i) answered += send();
    return answered;
  }
  /// It is started again: another socket, nothing in effect.
  void restart(std::uint64_t ipoc = 0) {
    rig.pass(500ms);
    rig.ipoc = ipoc;
    rig.delay = 0;
    ++rig.source.port;
    rig.applied.setZero();
  }

  StreamRig rig;
  bool counts_timeouts = true;
  bool shows_correction = true;
  double greatest_step_deg = 0;

 private:
  void take(const std::string& reply) {
    const rsi::SensorFrame frame = rig.decode(reply);
    ASSERT_EQ(frame.ipoc, rig.ipoc);
    for (std::size_t i = 0; i < 6; ++i) {
      double& axis = rig.applied[static_cast<Eigen::Index>(i)];
      const double value = (*frame.axis_correction_rad)[i];
      greatest_step_deg = std::max(greatest_step_deg, std::abs(value - axis) * kDegPerRad);
      axis = value;
    }
    if (!shows_correction) rig.stuck = rig.q;
    ++rig.ipoc;
  }

  std::chrono::milliseconds patience_;
};

/// Corrects until all of it is in effect.
void correct(WaitingSimulator& simulator) {
  simulator.rig.cycle->use_model(kFarOff, 1);
  simulator.rig.cycle->engage();
  simulator.send(kRampCycles + 30);
  ASSERT_EQ(simulator.rig.state(), StreamState::Active) << reason(simulator.rig.status());
  ASSERT_GT(simulator.rig.largest_applied_deg(), 1);
}

const double kBound_deg = stream_options().max_step_rad * kDegPerRad + 1e-9;

TEST(APeerThatWaits, IsAnsweredAfterItsFrameHasComeThreeTimes) {
  WaitingSimulator simulator;
  EXPECT_EQ(simulator.send(2), 0);
  EXPECT_TRUE(simulator.send());
  EXPECT_EQ(simulator.rig.state(), StreamState::Unproven) << "until it shows that it has taken the reply";
  EXPECT_EQ(simulator.send(100), 100);
  correct(simulator);
  EXPECT_LE(simulator.greatest_step_deg, kBound_deg);
}

TEST(APeerThatWaits, IsAnsweredWhereItCountsNoTimeouts) {
  WaitingSimulator simulator;
  simulator.counts_timeouts = false;
  EXPECT_EQ(simulator.send(100), 98);
  correct(simulator);
}

TEST(APeerThatWaits, IsAnsweredAfter40MsAndWithoutAsPosWhereItsCountIs0) {
  WaitingSimulator simulator{0, 40ms, next_process(), without_aspos()};
  simulator.counts_timeouts = false;
  EXPECT_EQ(simulator.send(100), 98);
  correct(simulator);
  WaitingSimulator elsewhere{1000, 40ms, fresh_cell(), without_aspos()};
  EXPECT_EQ(elsewhere.send(100), 0) << "nothing shows that the arm stands";
}

TEST(APeerThatWaits, IsAnsweredAtAnyCountWhereNoCorrectionWasEverSent) {
  WaitingSimulator fresh{123'456};
  EXPECT_EQ(fresh.send(100), 98);
  // One cycle after a correction that the arm does not show yet, in front of a daemon that knows of none.
  WaitingSimulator corrected{123'456, 1s, next_process()};
  corrected.rig.applied = axes_deg({0.5, 0, 0, 0, 0, 0});
  corrected.rig.stuck = corrected.rig.q;
  EXPECT_EQ(corrected.send(100), 0);
  EXPECT_THAT(reason(corrected.rig.status()), HasSubstr("start it again, with an IPOC that begins at 0"));
}

TEST(APeerThatWaits, IsNotAnsweredWhereItsAxesShowACorrection) {
  WaitingSimulator simulator{123'456};
  simulator.rig.applied = axes_deg({0, 0, 0.5, 0, 0, 0});
  EXPECT_EQ(simulator.send(100), 0);
}

TEST(APeerThatWaits, IsNoOtherArmWhereItFillsItsPoseWithZeros) {
  WaitingSimulator simulator{0, 1s, fresh_cell(), shipped_ethernet_config()};
  simulator.rig.rist = rsi::CartesianPose{};
  simulator.send(10);
  EXPECT_EQ(simulator.rig.status().fault, StreamFault::None);
  simulator.rig.rist->x_mm = 1;
  simulator.send(300);
  EXPECT_EQ(simulator.rig.status().fault, StreamFault::WrongArm);
}

TEST(APeerThatWaits, IsAnsweredAgainWhereItIsStartedAgainInTheMidstOfACorrection) {
  WaitingSimulator simulator;
  correct(simulator);
  simulator.restart();
  simulator.greatest_step_deg = 0;
  EXPECT_EQ(simulator.send(kRampCycles + 32), kRampCycles + 30);
  EXPECT_LE(simulator.greatest_step_deg, kBound_deg);
  simulator.restart(777);
  EXPECT_EQ(simulator.send(20), 0) << "at another count it may be the same as before, with its correction";
}

TEST(APeerThatWaits, GoesOnAfterALostReplyWithoutAJump) {
  WaitingSimulator simulator;
  correct(simulator);
  const JointVector before = simulator.rig.applied;
  EXPECT_FALSE(simulator.send(true));
  EXPECT_EQ(simulator.send(20), 18) << "the same reply once more, then two frames until it is known to wait";
  EXPECT_LE(simulator.greatest_step_deg, kBound_deg);
  EXPECT_LE((simulator.rig.applied - before).cwiseAbs().maxCoeff() * kDegPerRad, kBound_deg);
}

TEST(APeerThatWaits, GoesOnFromTheCorrectionThatTheProcessBeforeLeft) {
  const auto memory = StreamMemory::in_process();
  WaitingSimulator simulator{0, 1s, fresh_cell(), ethernet_config(), memory.get()};
  correct(simulator);
  const JointVector before = simulator.rig.applied;
  simulator.rig.pass(5s);
  simulator.rig.cycle =
      StreamCycle::create(nominal_arm(), ethernet_config(), next_process(), memory.get()).value();
  EXPECT_EQ(simulator.send(2), 0);
  EXPECT_TRUE(simulator.send());
  EXPECT_EQ(simulator.rig.applied, before);
  simulator.send(2 * kRampCycles);
  EXPECT_TRUE(simulator.rig.applied.isZero(0)) << "nobody has started the stream of this process";
  EXPECT_LE(simulator.greatest_step_deg, kBound_deg);
}

TEST(APeerThatWaits, IsAnsweredByTheNextProcessWhereTheReplyOfTheOneBeforeWasLost) {
  const auto memory = StreamMemory::in_process();
  WaitingSimulator simulator{0, 1s, fresh_cell(), ethernet_config(), memory.get()};
  correct(simulator);
  simulator.send(true);
  simulator.rig.cycle =
      StreamCycle::create(nominal_arm(), ethernet_config(), next_process(), memory.get()).value();
  EXPECT_EQ(simulator.send(5), 3);
  EXPECT_LE(simulator.greatest_step_deg, kBound_deg);
}

/// A controller with a correction of another process, whose frames stand in a queue.
class AQueue : public testing::Test {
 protected:
  AQueue() : rig{fresh_cell()} { rig.applied = axes_deg({0.5, 0, 0, 0, 0, 0}); }

  /// The same frame once more, as if the arm did not show the correction yet.
  std::string again(drivers::Duration after) {
    rig.pass(after);
    rig.stuck = rig.q;
    return rig.send(rig.datagram());
  }

  StreamRig rig;
};

TEST_F(AQueue, ThatRepeatsAFrameIsNoPeerThatWaits) {
  for (int i = 0; i < 20; ++i) EXPECT_EQ(again(4ms), "");
  EXPECT_EQ(again(40ms), "");
  rig.ipoc += 4;
  EXPECT_EQ(again(40ms), "") << "another frame came meanwhile";
  EXPECT_EQ(again(40ms), "");
}

TEST_F(AQueue, ThatLooksLikeOneProvesNothingWhereTheReplyWasNotTaken) {
  for (int i = 0; i < 2; ++i) EXPECT_EQ(again(40ms), "");
  const std::string offered = again(40ms);
  ASSERT_NE(offered, "");
  EXPECT_EQ(rig.decode(offered).axis_correction_rad, rsi::Axes{});
  // The controller has long been elsewhere, and counts that cycle as not answered.
  ++rig.delay;
  for (int i = 0; i < 50; ++i) {
    rig.ipoc += 4;
    EXPECT_EQ(again(4ms), "") << "cycle " << i;
    rig.q[0] += 0.3 * kRadPerDeg;
    ++rig.delay;
  }
}

TEST_F(AQueue, ThatLooksLikeOneProvesNothingWhereCyclesAreMissing) {
  for (int i = 0; i < 3; ++i) again(40ms);
  rig.ipoc += 8;
  EXPECT_EQ(again(4ms), "");
}

}  // namespace
}  // namespace truepose::daemon
