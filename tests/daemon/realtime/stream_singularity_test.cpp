#include <gtest/gtest.h>

#include <vector>

#include "core/arm/forward.hpp"
#include "core/simulate/published_arm.hpp"
#include "daemon/realtime/stream_cycle.hpp"
#include "tests/daemon/engaged_stream.hpp"

namespace truepose::daemon {
namespace {

/// How far (mm) the point of the real arm is from where the nominal arm would have it.
double off_mm(const StreamRig& rig, const RobotModel& real, const Eigen::Vector3d& p_F_mm) {
  return (forward_kinematics(real, rig.q + rig.applied) * p_F_mm -
          forward_kinematics(nominal_arm(), rig.q) * p_F_mm)
      .norm();
}

TEST(StreamAtSingularity, PassesAStretchedWristWithTheTcpInPlaceAndWithoutAJump) {
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

TEST(StreamAtSingularity, DampsNothingWhereTheCellSaysNever) {
  StreamOptions options = stream_options();
  options.singular_below_rad = 0;
  StreamRig rig{options};
  rig.q[4] = 5 * kRadPerDeg;
  engage(rig);
  EXPECT_EQ(rig.status().counters.damped, 0u);
}

TEST(StreamAtSingularity, HoldsWhereOnlyASingularityAsksForALargeCorrectionAndGoesOnBeyond) {
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

TEST(StreamAtSingularity, LeadsANearlyStretchedArmNoFurtherOffThanItWasWhereTheTotalIsTooSmall) {
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

TEST(StreamAtSingularity, StreamsAtAStretchedWristForAsLongAsTheArmStandsThere) {
  StreamRig rig;
  rig.q[4] = 0;
  rig.cycle->use_model(real_arm(), 1);
  rig.cycle->engage();
  rig.ticks(1000);
  EXPECT_EQ(rig.state(), StreamState::Active) << reason(rig.status());
}

}  // namespace
}  // namespace truepose::daemon
