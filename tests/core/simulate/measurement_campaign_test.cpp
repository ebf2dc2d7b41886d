#include "core/simulate/measurement_campaign.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "config/robot_file.hpp"
#include "core/arm/forward.hpp"
#include "core/calibrate/calibrate.hpp"
#include "core/simulate/published_arm.hpp"

namespace truepose {
namespace {

RobotModel kr210() { return config::load_robot(TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml"); }

TrueArmSetup arm(NonGeometricErrors non_geometric = {}) {
  TrueArmSetup setup{.robot = with_published_errors(kr210()),
                     .non_geometric = std::move(non_geometric),
                     .p_FS_mm = {80, 40, 120},
                     .repeatability_mm = kRepeatability_mm};
  setup.X_WB.translation() = Eigen::Vector3d{4000, 500, -300};
  setup.X_WB.rotate(Eigen::AngleAxisd{2.1, Eigen::Vector3d::UnitZ()});
  return setup;
}

struct Poses {
  std::vector<JointVector> identify, validate;
};

Poses poses(int identify, int validate, std::uint64_t seed) {
  Random random{seed};
  const RobotModel robot = kr210();
  auto first = random_poses(robot, identify, random);
  return {std::move(first), random_poses(robot, validate, random)};
}

TEST(RandomPoses, StayInTheLimitsAndAboveTheFloor) {
  Random random{1};
  const RobotModel robot = kr210();
  const auto found = random_poses(robot, 200, random);
  ASSERT_EQ(found.size(), 200u);
  for (const JointVector& q : found) {
    for (int i = 0; i < 6; ++i) {
      EXPECT_GE(q[i], robot.joints[static_cast<std::size_t>(i)].min);
      EXPECT_LE(q[i], robot.joints[static_cast<std::size_t>(i)].max);
    }
    EXPECT_GT(forward_kinematics(robot, q).translation().z(), 0);
  }
}

TEST(MeasurementCampaign, AddsTheTrackersNoiseAndTheArmsRepeatability) {
  const Poses p = poses(2000, 10, 2);
  const SimulatedCampaign campaign = measure_campaign(arm(), p.identify, p.validate, {.seed = 3});
  ASSERT_EQ(campaign.data.points.size(), 2010u);
  EXPECT_EQ(campaign.data.points[1999].set, PoseSet::Identify);
  EXPECT_EQ(campaign.data.points[2000].set, PoseSet::Validate);
  double squares = 0;
  for (std::size_t i = 0; i < 2010; ++i)
    squares += (campaign.data.points[i].p_WS_mm - campaign.p_true_mm[i]).squaredNorm();
  const double sigma_mm = std::hypot(kTrackerNoise_mm, kRepeatability_mm);
  EXPECT_NEAR(std::sqrt(squares / 6030) / sigma_mm, 1, 5 / std::sqrt(2 * 6030.0));
}

TEST(MeasurementCampaign, IsReplayedByItsSeedAndOnlyItsFaultyReadingsChangeWithGrossErrors) {
  const Poses p = poses(40, 10, 4);
  const SimulatedCampaign clean = measure_campaign(arm(), p.identify, p.validate, {.seed = 5});
  const SimulatedCampaign spoilt =
      measure_campaign(arm(), p.identify, p.validate, {.gross = {.fraction = 0.05}, .seed = 5});
  EXPECT_EQ(std::ranges::count(spoilt.gross, true), 2);
  for (std::size_t i = 0; i < 50; ++i) {
    const double off_mm = (spoilt.data.points[i].p_WS_mm - clean.data.points[i].p_WS_mm).norm();
    if (!spoilt.gross[i]) {
      EXPECT_EQ(off_mm, 0);
      continue;
    }
    EXPECT_LT(i, 40u);
    EXPECT_GE(off_mm, 5);
    EXPECT_LE(off_mm, 50);
  }
}

TEST(MeasurementCampaign, RecordsTheDirectionInWhichEachJointLastMoved) {
  const Poses p = poses(5, 1, 6);
  const SimulatedCampaign campaign = measure_campaign(arm(), p.identify, p.validate, {});
  EXPECT_EQ(campaign.data.points[0].direction, ApproachDirections(6, 0));
  for (std::size_t k = 1; k < 6; ++k) {
    const JointVector turned = campaign.data.points[k].q - campaign.data.points[k - 1].q;
    for (int i = 0; i < 6; ++i)
      EXPECT_EQ(campaign.data.points[k].direction[static_cast<std::size_t>(i)], turned[i] > 0 ? 1 : -1);
  }
  const SimulatedCampaign silent =
      measure_campaign(arm(), p.identify, p.validate, {.record_directions = false});
  EXPECT_TRUE(silent.data.points[3].direction.empty());
}

TEST(MeasurementCampaign, OfTheHeavyArmLeavesAGeometricModelWithTenthsOfAMillimetre) {
  const auto mean_error_mm = [](const HeavyArmOptions& options) {
    const Poses p = poses(100, 200, 7);
    const SimulatedCampaign campaign =
        measure_campaign(arm(heavy_arm_errors(options)), p.identify, p.validate, {.seed = 8});
    return calibrate(kr210(), campaign.data)->validate->geometric.mean;
  };
  EXPECT_GT(mean_error_mm({}), 0.35);
  EXPECT_LT(mean_error_mm({}), 0.55);
  EXPECT_GT(mean_error_mm({.compliance = false}), 0.10);
  EXPECT_LT(mean_error_mm({.compliance = false}), 0.20);
  EXPECT_LT(mean_error_mm({.compliance = false, .harmonics = false}), 0.04);
}

}  // namespace
}  // namespace truepose
