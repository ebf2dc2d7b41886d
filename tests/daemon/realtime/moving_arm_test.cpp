#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "tests/daemon/corrected_stream.hpp"
#include "tests/trials.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;

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

std::string described(const MovingArm& arm) {
  std::ostringstream text;
  text << "legs of " << arm.leg_cycles << " cycles, " << arm.lag_cycles << " cycles of lag that swings by "
       << arm.lag_swings_by << ", " << arm.dead_cycles << " dead, friction " << arm.friction_deg << " deg, "
       << arm.lost_in_a_row << " datagrams lost in " << arm.datagram_lost_every << ", a reply in "
       << arm.reply_lost_every;
  return text.str();
}

TEST(AStreamToAMovingArm, FindsWithinTwoSecondsThatItsCorrectionsDoNothingWhileTheArmMovesAtFullSpeed) {
  for (MovingArm arm : moving_arms()) {
    SCOPED_TRACE(described(arm));
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

TEST(AStreamToAMovingArm, MeasuresTheCorrectionInEffectAndAcceptsAnyLag) {
  for (MovingArm arm : moving_arms()) {
    SCOPED_TRACE(described(arm));
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
TEST(AStreamToAMovingArm, AccusesNoHealthyArmAfterAnEmergencyStopThatWasAcknowledged) {
  const int stops = all_trials() ? 3 : 1;
  int frozen = 0;
  for (MovingArm arm : moving_arms()) {
    if (arm.lag_cycles + static_cast<double>(arm.dead_cycles) == 0) continue;  // it is nowhere else when held
    SCOPED_TRACE(described(arm));
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
    for (int stop = 0; stop < stops; ++stop) {
      move(1500 + 170 * stop);
      if (testing::Test::HasFatalFailure()) return;
      arm.be_held(rig, 1500);
      frozen += rig.state() == StreamState::Frozen;
      rig.cycle->acknowledge();
    }
    move(3000);
  }
  EXPECT_GT(frozen, 20 * stops) << "of " << 27 * stops << " stops";
}

}  // namespace
}  // namespace truepose::daemon
