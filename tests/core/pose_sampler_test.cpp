#include "core/planning/pose_sampler.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "core/kinematics/angles.hpp"
#include "core/kinematics/forward.hpp"
#include "tests/daemon/example_cell.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;

LineOfSight example_sight() {
  const config::CellConfig cell = test::example_cell();
  return {cell.tracker.placement, cell.reflector.p_FS_mm, cell.reflector.facing_F, 30 * kRadPerDeg};
}

PoseSamplerOptions example_options() {
  PoseSamplerOptions options;
  options.seed = 42;
  options.limit_margin_rad = 5 * kRadPerDeg;
  return options;
}

TEST(PoseSampler, PosesAreWithinTheLimitsAboveTheFloorAndSeenByTheTracker) {
  const RobotModel robot = test::kr210();
  const LineOfSight sight = example_sight();
  const PoseSamplerOptions options = example_options();
  const auto poses = sample_poses(robot, sight, options);
  ASSERT_TRUE(poses) << poses.error();
  ASSERT_EQ(poses->size(), 60U);
  for (const JointVector& q : *poses) {
    for (int i = 0; i < 6; ++i) {
      const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
      EXPECT_GE(q[i], joint.min + options.limit_margin_rad);
      EXPECT_LE(q[i], joint.max - options.limit_margin_rad);
    }
    const Eigen::Isometry3d X_BF = forward_kinematics(robot, q);
    EXPECT_GE(X_BF.translation().z(), options.floor_mm);
    EXPECT_GE((X_BF * sight.p_FS_mm).z(), options.floor_mm);
    const Eigen::Isometry3d X_WF = sight.X_WB * X_BF;
    const Eigen::Vector3d to_tracker = -(X_WF * sight.p_FS_mm).normalized();
    const double off_rad = std::acos(to_tracker.dot(X_WF.linear() * sight.facing_F));
    EXPECT_LE(off_rad, sight.acceptance_rad + 1e-12);
  }
}

TEST(PoseSampler, TheSameSeedGivesTheSamePosesAndAnotherSeedOthers) {
  const RobotModel robot = test::kr210();
  PoseSamplerOptions options = example_options();
  const auto first = sample_poses(robot, example_sight(), options);
  const auto again = sample_poses(robot, example_sight(), options);
  options.seed = 43;
  const auto other = sample_poses(robot, example_sight(), options);
  ASSERT_TRUE(first && again && other);
  EXPECT_EQ(*first, *again);
  EXPECT_NE(*first, *other);
}

TEST(PoseSampler, SaysWhatMostPosesFailedOnWhenThereAreNotEnough) {
  LineOfSight sight = example_sight();
  sight.acceptance_rad = 0.1 * kRadPerDeg;
  PoseSamplerOptions options = example_options();
  options.candidates = 2000;
  const auto poses = sample_poses(test::kr210(), sight, options);
  ASSERT_FALSE(poses);
  EXPECT_THAT(poses.error(), HasSubstr("of 60 poses found in 2000 tries"));
  EXPECT_THAT(poses.error(), HasSubstr("had the reflector turned away from the tracker"));

  options.floor_mm = 10000;
  sight.acceptance_rad = 179 * kRadPerDeg;
  const auto high = sample_poses(test::kr210(), sight, options);
  ASSERT_FALSE(high);
  EXPECT_THAT(high.error(), HasSubstr("came below the floor"));
}

TEST(PoseSampler, NamesTheJointThatTheMarginLeavesNothingOf) {
  PoseSamplerOptions options = example_options();
  options.limit_margin_rad = 70 * kRadPerDeg;
  const auto poses = sample_poses(test::kr210(), example_sight(), options);
  ASSERT_FALSE(poses);
  EXPECT_THAT(poses.error(), HasSubstr("joint 2"));
}

TEST(PoseOrder, KeepsEveryPoseAndShortensTheWay) {
  const RobotModel robot = test::kr210();
  const auto poses = sample_poses(robot, example_sight(), example_options());
  ASSERT_TRUE(poses);
  const JointVector start = JointVector::Zero(6);
  const std::vector<JointVector> ordered = order_by_travel(robot, start, *poses);
  EXPECT_THAT(ordered, testing::UnorderedElementsAreArray(*poses));

  const auto way_s = [&](const std::vector<JointVector>& path) {
    double sum = travel_time_s(robot, start, path.front());
    for (std::size_t i = 1; i < path.size(); ++i) sum += travel_time_s(robot, path[i - 1], path[i]);
    return sum;
  };
  EXPECT_LT(way_s(ordered), 0.8 * way_s(*poses));
}

TEST(TravelTime, IsThatOfTheSlowestJoint) {
  const RobotModel robot = test::kr210();
  JointVector from = JointVector::Zero(6);
  JointVector to = from;
  to[0] = 117 * kRadPerDeg;
  to[5] = 100 * kRadPerDeg;
  EXPECT_NEAR(travel_time_s(robot, from, to), 1.0, 1e-12);
}

}  // namespace
}  // namespace truepose
