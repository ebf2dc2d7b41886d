// The play of the gears under the stream: an arm whose joints trail their motors by it is the judge.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/arm/forward.hpp"
#include "core/compensate/target_compensation.hpp"
#include "core/simulate/published_arm.hpp"
#include "daemon/realtime/approach_watch.hpp"
#include "tests/daemon/stream_rig.hpp"

namespace truepose::daemon {
namespace {

constexpr double kShown_deg = 0.01;

/// One axis of a watch, the others at rest.
struct Axis {
  int at(double deg) {
    JointVector q = JointVector::Zero(6);
    q[2] = deg * kRadPerDeg;
    watch.take(q);
    EXPECT_EQ(watch.directions()[1], 0);
    return watch.directions()[2];
  }
  ApproachWatch watch;
};

TEST(ApproachWatch, KnowsNothingUntilAnAxisHasMoved) {
  Axis axis;
  EXPECT_EQ(axis.at(30), 0);
  EXPECT_EQ(axis.at(30 + 0.9 * kShown_deg), 0);
  EXPECT_EQ(axis.at(30 + 1.1 * kShown_deg), 1);
  axis.watch.restart();
  EXPECT_EQ(axis.at(20), 0) << "somewhere else now: that was no motion";
  EXPECT_EQ(axis.at(19), -1);
}

TEST(ApproachWatch, KeepsWhatItSawWhileAnAxisTrembles) {
  Axis axis;
  axis.at(0);
  EXPECT_EQ(axis.at(1), 1);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(axis.at(1 + (i % 2 ? -0.45 : 0.45) * kShown_deg), 1);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(axis.at(1), 1) << "and while it stands";
}

TEST(ApproachWatch, SeesATurnHoweverSlowTheAxisIs) {
  Axis axis;
  axis.at(0);
  double deg = 0;
  for (int i = 0; i < 1000; ++i) axis.at(deg += 0.0001);
  EXPECT_EQ(axis.at(deg), 1);
  double turned = deg;
  while (axis.at(deg) > 0) deg -= 0.0001;
  EXPECT_NEAR(turned - deg, kShown_deg, 0.0002);
}

/// Joints that trail their motors by a play: each stands still until its motor has crossed it.
class Gears {
 public:
  explicit Gears(double play_rad) : play_rad_{play_rad} {}
  const JointVector& turned_to(const JointVector& motors) {
    if (joints_.size() == 0) joints_ = motors;
    const JointVector half = JointVector::Constant(motors.size(), play_rad_ / 2);
    joints_ = joints_.cwiseMax(motors - half).cwiseMin(motors + half);
    return joints_;
  }

 private:
  double play_rad_;
  JointVector joints_;
};

RobotModel with_play(RobotModel robot, double play_rad) {
  for (int joint = 0; joint < robot.joint_count(); ++joint)
    robot.deviation.push_back(
        {.joint = joint, .basis = DeviationBasis::Approach, .coefficient = -play_rad / 2});
  return robot;
}

/// Axes that go to and fro, each at a time of its own, from `q` at the time 0.
JointVector swung(const JointVector& q, double s) {
  JointVector swung = q;
  for (Eigen::Index i = 0; i < q.size(); ++i)
    swung[i] += 3 * kRadPerDeg * std::sin(2 * std::numbers::pi * s / (6 + static_cast<double>(i)));
  return swung;
}

TEST(StreamCycle, TakesThePlayOfTheGearsOutOnTheSideFromWhichEachAxisCame) {
  constexpr double kPlay_deg = 0.006;
  for (const bool sends_commanded : {true, false}) {
    rsi::EthernetConfig config = ethernet_config();
    if (!sends_commanded) std::erase_if(config.send, [](const auto& e) { return e.tag == "DEF_ASPos"; });
    StreamRig rig{stream_options(), config};
    const JointVector start = rig.q;
    Gears gears{kPlay_deg * kRadPerDeg};
    rig.settle();
    rig.cycle->use_model(with_play(nominal_arm(), kPlay_deg * kRadPerDeg), 1);
    rig.cycle->engage();
    rig.ticks(300);
    int right = 0, cycles = 0;
    double worst_deg = 0;
    for (int i = 0; i < 5000; ++i) {
      rig.q = swung(start, 0.004 * i);
      rig.tick();
      const JointVector off_deg = (gears.turned_to(rig.q + rig.applied) - rig.q) * kDegPerRad;
      worst_deg = std::max(worst_deg, off_deg.cwiseAbs().maxCoeff());
      if (i < 500) continue;  // no axis has moved at first
      ++cycles;
      right += off_deg.cwiseAbs().maxCoeff() < 0.0001;
    }
    EXPECT_EQ(rig.state(), StreamState::Active) << reason(rig.status());
    if (sends_commanded) {
      EXPECT_GT(right, 0.8 * cycles) << "all but where one of six axes has just turned";
      EXPECT_LT(worst_deg, kPlay_deg + kShown_deg);
    } else {
      EXPECT_TRUE(rig.applied.isZero(0)) << "in the middle: guessed axes would be turned by what is sent";
    }
  }
}

/// How far the calibrated arm is from where the nominal one would be.
double off_mm(const StreamRig& rig, const RobotModel& real) {
  return (forward_kinematics(real, rig.q + rig.applied).translation() -
          forward_kinematics(nominal_arm(), rig.q).translation())
      .norm();
}

TEST(StreamCycle, HoldsWhileALongSearchGoesOnOverSomeCyclesAndCountsThem) {
  const RobotModel real = with_published_errors(nominal_arm());
  const TargetCompensation compensation{nominal_arm(), real};
  StreamRig rig;
  int steps = 0;
  for (double a3_deg = 10; a3_deg > 0 && steps < 10; a3_deg -= 0.01) {
    rig.q = axes_deg({20, -60, a3_deg, 30, 45, -40});
    const auto compensated = compensation.at_joints(rig.q);
    steps = compensated ? compensated->iterations : 0;
  }
  ASSERT_GE(steps, 10) << "near the end of its reach";
  rig.settle();
  rig.cycle->use_model(real, 1);
  rig.cycle->engage();
  rig.tick();
  EXPECT_EQ(rig.status().counters.no_solution, 1u);
  EXPECT_TRUE(rig.applied.isZero(0));
  rig.ticks(400);
  EXPECT_LE(rig.status().counters.no_solution, static_cast<std::uint64_t>(steps) / 8 + 1);
  EXPECT_LT(rig.status().state == StreamState::Active ? off_mm(rig, real) : 0, 0.01);
}

}  // namespace
}  // namespace truepose::daemon
