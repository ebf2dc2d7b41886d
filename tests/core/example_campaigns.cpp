#include "tests/core/example_campaigns.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/simulate/published_arm.hpp"
#include "tests/core/example_arms.hpp"

namespace truepose::example {

TrueArmSetup true_arm(NonGeometricErrors errors) {
  TrueArmSetup setup{.robot = with_published_errors(kr210()),
                     .non_geometric = std::move(errors),
                     .p_FS_mm = {80, 40, 120},
                     .repeatability_mm = kRepeatability_mm};
  setup.X_WB.translation() = Eigen::Vector3d{4000, 500, -300};
  setup.X_WB.rotate(Eigen::AngleAxisd{2.1, Eigen::Vector3d::UnitZ()});
  return setup;
}

SimulatedCampaign campaign(const TrueArmSetup& setup, int identify, int validate, CampaignOptions options) {
  Random random{options.seed + 1000};
  const RobotModel robot = kr210();
  const auto measured = random_poses(robot, identify, random);
  return measure_campaign(setup, measured, random_poses(robot, validate, random), options);
}

double mean_miss(const CalibratedCell& cell, const SimulatedCampaign& campaign) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < campaign.data.points.size(); ++i) {
    const Measurement& m = campaign.data.points[i];
    if (m.set != PoseSet::Validate) continue;
    sum += (cell.predict(m.q, m.smr, m.direction) - campaign.p_true_mm[i]).norm();
    ++count;
  }
  return sum / count;
}

double mean_miss(const std::expected<Calibration, CalibrationError>& calibration,
                 const SimulatedCampaign& campaign) {
  EXPECT_TRUE(calibration.has_value()) << (calibration ? "" : calibration.error().detail);
  return calibration ? mean_miss(calibration->cell, campaign) : HUGE_VAL;
}

}  // namespace truepose::example
