#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/math/random.hpp"
#include "core/simulate/joint_motion.hpp"
#include "core/simulate/true_arm.hpp"
#include "tests/core/two_joints.hpp"

namespace truepose {
namespace {

/// An arm of two joints in a vertical plane: q = 0 stretches it along x at a height of 400 mm.
RobotModel planar_arm() {
  RobotModel robot;
  robot.joints = {{.d_mm = 400, .min = -3, .max = 3, .speed = 2.0},
                  {.a_mm = 100, .alpha_rad = -std::numbers::pi / 2, .min = -3, .max = 3, .speed = 0.5}};
  robot.X_flange.translation() = Eigen::Vector3d{500, 0, 0};
  return robot;
}

TEST(WarmUp, MovesZerosInTheSenseOfTheJointAndLetsLengthsGrowByOneExponential) {
  RobotModel cold = planar_arm();
  cold.joints[1].sign = -1;
  const WarmUp warm_up{.zero = JointVector::Constant(2, 1e-3), .growth = 2e-4, .time_constant = Seconds{600}};
  EXPECT_EQ(warmed(cold, warm_up, Seconds{0}).joints[1].theta_rad, 0);
  const RobotModel after_one = warmed(cold, warm_up, Seconds{600});
  const double share = 1 - std::exp(-1);
  EXPECT_NEAR(after_one.joints[0].theta_rad, 1e-3 * share, 1e-15);
  EXPECT_NEAR(after_one.joints[1].theta_rad, -1e-3 * share, 1e-15);
  EXPECT_NEAR(after_one.joints[0].d_mm, 400 * (1 + 2e-4 * share), 1e-12);
  EXPECT_NEAR(warmed(cold, warm_up, Seconds{1e6}).joints[1].a_mm, 100 * (1 + 2e-4), 1e-12);
}

TEST(TrueArm, StandsElsewhereTheWarmerItIs) {
  TrueArmSetup setup{.robot = planar_arm()};
  setup.warm_up = {.zero = JointVector::Constant(2, 1e-3), .time_constant = Seconds{600}};
  TrueArm arm(setup, 1);
  const JointVector q = JointVector::Zero(2);
  const Eigen::Vector3d cold = arm.p_WS_mm(q);
  double last = 0;
  for (const double s : {60.0, 600.0, 6000.0}) {
    arm.warm_up(Seconds{s});
    const double moved = (arm.p_WS_mm(q) - cold).norm();
    EXPECT_GT(moved, last);
    last = moved;
  }
  // Both axes by 1 mrad, 600 and 500 mm from the flange.
  EXPECT_NEAR(last, std::hypot(0.6, 0.5), 1e-3);
}

struct Moments {
  double mean, std;
};

Moments moments(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double value : values) sum += value;
  const double mean = sum / static_cast<double>(values.size());
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / static_cast<double>(values.size()))};
}

TEST(Random, ReplaysTheReferenceSequenceOfItsSeed) {
  Random random{1234567};
  EXPECT_EQ(random.next(), 6457827717110365317u);
  EXPECT_EQ(random.next(), 3203168211198807973u);
  EXPECT_EQ(random.next(), 9817491932198370423u);
}

TEST(Random, UniformStaysInItsIntervalAndNormalIsNormal) {
  Random random{42};
  std::vector<double> normal;
  int beyond_two = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    normal.push_back(random.normal());
    beyond_two += std::abs(normal.back()) > 2.0;
  }
  // Five standard errors of a sample of this size.
  EXPECT_NEAR(moments(normal).mean, 0.0, 5 / std::sqrt(1e5));
  EXPECT_NEAR(moments(normal).std, 1.0, 5 / std::sqrt(2e5));
  EXPECT_NEAR(beyond_two / 1e5, 0.0455, 5 * std::sqrt(0.0455 / 1e5));
}

TEST(TrackerNoise, IsSmallAlongTheBeamAndGrowsAcrossItWithTheDistance) {
  const TrackerNoiseModel model{
      .range_mm = 0.002, .range_mm_per_m = 0.0001, .transverse_mm = 0.004, .transverse_mm_per_m = 0.0015};
  const Eigen::Vector3d p{3000, -4000, 0};  // 5 m away
  const Eigen::Vector3d along = p.normalized();
  const Eigen::Vector3d across = Eigen::Vector3d::UnitZ();
  Random random{3};
  std::vector<double> range, vertical, horizontal;
  for (int i = 0; i < 20'000; ++i) {
    const Eigen::Vector3d error = noisy_reading(p, model, random) - p;
    range.push_back(error.dot(along));
    vertical.push_back(error.dot(across));
    horizontal.push_back(error.dot(along.cross(across)));
  }
  const double tolerance = 5 / std::sqrt(2 * 20'000.0);
  EXPECT_NEAR(moments(range).std / 0.0025, 1, tolerance);
  EXPECT_NEAR(moments(vertical).std / 0.0115, 1, tolerance);
  EXPECT_NEAR(moments(horizontal).std / 0.0115, 1, tolerance);
  EXPECT_NEAR(moments(range).mean / 0.0025, 0, 5 / std::sqrt(20'000.0));
}

TEST(TrueArm, StandsWhereItsOwnKinematicsPutItWhenItRepeatsPerfectly) {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.translate(Eigen::Vector3d{2000, 100, -500}).rotate(Eigen::AngleAxisd{0.3, Eigen::Vector3d::UnitZ()});
  const TrueArm arm{{.robot = planar_arm(), .X_WB = X_WB, .p_FS_mm = {10, 20, 30}}, 1};
  const JointVector q = two_joints(0.2, -0.4);
  const Eigen::Vector3d expected = X_WB * (forward_kinematics(planar_arm(), q) * Eigen::Vector3d{10, 20, 30});
  EXPECT_LT((arm.p_WS_mm(q) - expected).norm(), 1e-12);
}

TEST(TrueArm, DrawsItsRepeatabilityAtEachStopAndKeepsStillBetween) {
  const double sigma_mm = 0.0166;
  TrueArm arm{{.robot = planar_arm(), .repeatability_mm = sigma_mm}, 5};
  TrueArm replay{{.robot = planar_arm(), .repeatability_mm = sigma_mm}, 5};
  const TrueArm perfect{{.robot = planar_arm()}, 5};
  const JointVector q = two_joints(0.2, -0.4);
  std::vector<double> x, y, z;
  for (int i = 0; i < 20'000; ++i) {
    arm.stop_anew();
    replay.stop_anew();
    const Eigen::Vector3d deviation = arm.p_WS_mm(q) - perfect.p_WS_mm(q);
    ASSERT_EQ(arm.p_WS_mm(q), arm.p_WS_mm(q));
    ASSERT_EQ(arm.p_WS_mm(q), replay.p_WS_mm(q));
    x.push_back(deviation.x());
    y.push_back(deviation.y());
    z.push_back(deviation.z());
  }
  for (const auto* axis : {&x, &y, &z}) {
    EXPECT_NEAR(moments(*axis).std / sigma_mm, 1, 5 / std::sqrt(40'000.0));
    EXPECT_NEAR(moments(*axis).mean / sigma_mm, 0, 5 / std::sqrt(20'000.0));
  }
}

TEST(TrueArm, StandsElsewhereWhenItsJointsArriveFromTheOtherSide) {
  NonGeometricErrors play;
  play.drives.resize(2);
  play.drives[0].backlash_rad = 1e-3;
  TrueArm arm{{.robot = planar_arm(), .non_geometric = play}, 1};
  const TrueArm exact{{.robot = planar_arm()}, 1};
  const JointVector q = two_joints(0.2, -0.4);
  EXPECT_TRUE(arm.directions().empty());
  EXPECT_EQ(arm.p_WS_mm(q), exact.p_WS_mm(q));
  arm.move_to(two_joints(0, -0.4));
  arm.move_to(q);
  EXPECT_EQ(arm.directions(), (ApproachDirections{1, 0}));
  EXPECT_LT((arm.p_WS_mm(q) - exact.p_WS_mm(two_joints(0.2 - 0.5e-3, -0.4))).norm(), 1e-9);
  arm.move_to(two_joints(0.2, 0));
  EXPECT_EQ(arm.directions(), (ApproachDirections{1, 1})) << "a joint that does not turn keeps its direction";
  arm.move_to(two_joints(0.3, 0));
  arm.move_to(q);
  EXPECT_EQ(arm.directions(), (ApproachDirections{-1, -1}));
  EXPECT_LT((arm.p_WS_mm(q) - exact.p_WS_mm(two_joints(0.2 + 0.5e-3, -0.4))).norm(), 1e-9);
}

TEST(TrueArm, IsSeenOnlyInsideTheAcceptanceConeOfItsReflector) {
  // The tracker stands on the x axis, level with the reflector, 4 m from the base.
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.translation() = Eigen::Vector3d{-4000, 0, -400};
  const TrueArm arm{{.robot = planar_arm(), .X_WB = X_WB, .facing_F = {2, 0, 0}, .acceptance_rad = 0.5}, 1};
  EXPECT_TRUE(arm.visible(two_joints(0, 0)));
  EXPECT_TRUE(arm.visible(two_joints(0.4, 0)));
  EXPECT_FALSE(arm.visible(two_joints(0.5, 0)))
      << "the base turns the reflector, and its side step adds to the angle";
  EXPECT_FALSE(arm.visible(two_joints(std::numbers::pi, 0)));
}

TEST(TrueArm, IsNotSeenBelowTheFloor) {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.translation() = Eigen::Vector3d{-4000, 0, -400};
  const TrueArm arm{{.robot = planar_arm(), .X_WB = X_WB, .facing_F = {1, 0, 0}, .acceptance_rad = 3.1}, 1};
  const bool down_is_positive = arm.p_WS_mm(two_joints(0, 1)).z() < arm.p_WS_mm(two_joints(0, 0)).z();
  EXPECT_TRUE(arm.visible(two_joints(0, down_is_positive ? -1 : 1)));
  EXPECT_FALSE(arm.visible(two_joints(0, down_is_positive ? 1 : -1)));
}

TEST(JointMotion, StartsAndEndsExactlyAndNeverTurnsBack) {
  const RobotModel robot = planar_arm();
  for (const double size : {1e-6, 0.01, 0.3, 2.5}) {
    const JointVector from = two_joints(0.1, -0.2), to = two_joints(0.1 + size, -0.2 - size);
    const JointMotion motion{robot, from, to, 1.0};
    EXPECT_EQ(motion.position(Seconds{0}), from);
    EXPECT_EQ(motion.position(motion.duration()), to);
    EXPECT_EQ(motion.position(motion.duration() + Seconds{1}), to);
    JointVector before = from;
    for (int i = 1; i <= 1000; ++i) {
      const JointVector q = motion.position(motion.duration() * (i / 1000.0));
      ASSERT_GE(q[0], before[0]) << "size " << size << " step " << i;
      ASSERT_LE(q[1], before[1]) << "size " << size << " step " << i;
      ASSERT_NEAR(q[0] - from[0], from[1] - q[1], 1e-12) << "the joints are not synchronous";
      before = q;
    }
  }
}

TEST(JointMotion, RespectsTheSpeedOfTheSlowestJointAndTheRamp) {
  const RobotModel robot = planar_arm();
  const JointMotion motion{robot, two_joints(0, 0), two_joints(1, 2), 0.5, Seconds{0.5}};
  // 2 rad at half of 0.5 rad/s take 8 s, and half a second is lost on the ramps.
  EXPECT_NEAR(motion.duration().count(), 8.5, 1e-12);
  const double dt = 0.001;
  double fastest = 0, strongest = 0, speed_before = 0;
  for (double t = 0; t <= motion.duration().count() + dt; t += dt) {
    const double speed = (motion.position(Seconds{t + dt}) - motion.position(Seconds{t}))[1] / dt;
    fastest = std::max(fastest, speed);
    strongest = std::max(strongest, std::abs(speed - speed_before) / dt);
    speed_before = speed;
  }
  EXPECT_NEAR(fastest, 0.25, 1e-9);
  EXPECT_LE(strongest, 0.25 / 0.5 * 1.001);
}

TEST(JointMotion, WithoutDistanceIsOverAtOnce) {
  const JointMotion motion{planar_arm(), two_joints(1, 1), two_joints(1, 1), 0.1};
  EXPECT_EQ(motion.duration(), Seconds{0});
  EXPECT_EQ(motion.position(Seconds{0}), two_joints(1, 1));
}

}  // namespace
}  // namespace truepose
