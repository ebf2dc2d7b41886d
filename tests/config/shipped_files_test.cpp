#include <gtest/gtest.h>

#include "config/cell_config.hpp"
#include "config/robot_file.hpp"
#include "config/scenario.hpp"
#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"

namespace truepose::config {
namespace {

const std::filesystem::path kConfig = std::filesystem::path(TRUEPOSE_SOURCE_DIR) / "config";

TEST(ShippedFiles, TheRobotStandsWhereTheControllersPosesAre) {
  const RobotModel robot = load_robot(kConfig / "robots/kr210_r2700_2.yaml");
  const auto pose = [&](double a1, double a2, double a3, double a4, double a5, double a6) {
    return forward_kinematics(robot, (JointVector(6) << a1, a2, a3, a4, a5, a6).finished() * kRadPerDeg);
  };
  const Eigen::Isometry3d home = pose(0, -90, 90, 0, 0, 0);
  EXPECT_LT((home.translation() - Eigen::Vector3d(1765, 0, 1910)).norm(), 1e-9);
  // x = -Z, y = +Y, z = +X of the base.
  const Eigen::Matrix3d at_home = (Eigen::Matrix3d() << 0, 0, 1, 0, 1, 0, -1, 0, 0).finished();
  EXPECT_TRUE(home.linear().isApprox(at_home, 1e-12));

  // What the controller shows: mm to 1e-3, A B C to 1e-3 deg.
  const Eigen::Isometry3d X = pose(20, -70, 60, 15, -40, 100);
  const Eigen::Isometry3d shown = pose_from_kuka({1932.811, -665.422, 2210.812}, {-120.897, -20.988, -37.12});
  EXPECT_LT((X.translation() - shown.translation()).norm(), 1e-3);
  EXPECT_LT(angle_between(X.linear(), shown.linear()) * kDegPerRad, 2e-3);
}

TEST(ShippedFiles, TheExampleCellShowsTheDefaults) {
  const CellConfig cell = load_cell(kConfig / "cell.yaml"), defaults;
  EXPECT_EQ(cell.robot.model.joint_count(), 6);
  EXPECT_EQ(cell.robot.max_fk_deviation_mm, defaults.robot.max_fk_deviation_mm);
  EXPECT_EQ(cell.stream.cycle, defaults.stream.cycle);
  EXPECT_EQ(cell.stream.realtime, defaults.stream.realtime);
  EXPECT_EQ(cell.stream.priority, defaults.stream.priority);
  EXPECT_EQ(cell.stream.max_step_deg, defaults.stream.max_step_deg);
  EXPECT_EQ(cell.stream.max_total_deg, defaults.stream.max_total_deg);
  EXPECT_EQ(cell.stream.limit_margin_deg, defaults.stream.limit_margin_deg);
  EXPECT_EQ(cell.stream.singular_deg, defaults.stream.singular_deg);
  EXPECT_EQ(cell.stream.ramp, defaults.stream.ramp);
  EXPECT_EQ(cell.tracker.measure, defaults.tracker.measure);
  EXPECT_EQ(cell.tracker.search_first_mm, defaults.tracker.search_first_mm);
  EXPECT_EQ(cell.tracker.search_mm, defaults.tracker.search_mm);
  EXPECT_EQ(cell.tracker.gate_mm, defaults.tracker.gate_mm);
  EXPECT_EQ(cell.reflector.name, defaults.reflector.name);
  EXPECT_EQ(cell.reflector.acceptance_deg, defaults.reflector.acceptance_deg);
  EXPECT_EQ(cell.campaign.identify_poses, defaults.campaign.identify_poses);
  EXPECT_EQ(cell.campaign.validate_poses, defaults.campaign.validate_poses);
  EXPECT_EQ(cell.campaign.drift_poses, defaults.campaign.drift_poses);
  EXPECT_EQ(cell.campaign.coarse_after, defaults.campaign.coarse_after);
  EXPECT_EQ(cell.campaign.seed, defaults.campaign.seed);
  EXPECT_EQ(cell.campaign.speed_percent, defaults.campaign.speed_percent);
  EXPECT_EQ(cell.campaign.settle, defaults.campaign.settle);
  EXPECT_EQ(cell.campaign.warm_up, defaults.campaign.warm_up);
  EXPECT_EQ(cell.campaign.warm_up_moves, defaults.campaign.warm_up_moves);
  EXPECT_EQ(cell.campaign.retries, defaults.campaign.retries);
  EXPECT_EQ(cell.campaign.limit_margin_deg, defaults.campaign.limit_margin_deg);
  EXPECT_EQ(cell.campaign.wrist_margin_deg, defaults.campaign.wrist_margin_deg);
  EXPECT_EQ(cell.campaign.candidates, defaults.campaign.candidates);
  EXPECT_EQ(cell.campaign.criterion, defaults.campaign.criterion);
  EXPECT_EQ(cell.campaign.reference_every, defaults.campaign.reference_every);
  EXPECT_EQ(cell.campaign.approach, defaults.campaign.approach);
  EXPECT_EQ(cell.campaign.approach_deg, defaults.campaign.approach_deg);
  EXPECT_EQ(cell.surroundings.floor_mm, defaults.surroundings.floor_mm);
  EXPECT_EQ(cell.surroundings.clearance_mm, defaults.surroundings.clearance_mm);
  EXPECT_EQ(cell.surroundings.tracker_radius_mm, defaults.surroundings.tracker_radius_mm);
  EXPECT_EQ(cell.tracker.beam_radius_mm, defaults.tracker.beam_radius_mm);
  EXPECT_EQ(cell.tracker.noise.range_mm, defaults.tracker.noise.range_mm);
  EXPECT_EQ(cell.tracker.noise.transverse_mm_per_m, defaults.tracker.noise.transverse_mm_per_m);
  EXPECT_EQ(cell.robot.repeatability_mm, defaults.robot.repeatability_mm);
  EXPECT_EQ(cell.campaign.remeasure, defaults.campaign.remeasure);
  EXPECT_EQ(cell.control.listen.host, defaults.control.listen.host);
  EXPECT_EQ(cell.control.listen.port, defaults.control.listen.port);
  EXPECT_EQ(cell.log_level, defaults.log_level);
}

TEST(ShippedFiles, TheDemoScenarioIsTheArmOfThePaperNearTheExampleCellsGuess) {
  const CellConfig cell = load_cell(kConfig / "cell.yaml");
  const Scenario scenario = load_scenario(kConfig / "scenarios/demo.yaml");
  EXPECT_DOUBLE_EQ(scenario.truth.joints[1].a_mm, 330.63);
  EXPECT_DOUBLE_EQ(scenario.truth.joints[2].beta_rad, 0.001);
  EXPECT_NEAR(scenario.X_WB.translation().norm(), 3640, 10);
  EXPECT_EQ(scenario.ethernet_xml, cell.stream.ethernet_xml);
  EXPECT_TRUE(std::filesystem::exists(cell.stream.ethernet_xml));
  EXPECT_NE(scenario.robot_model.find(cell.robot.expect_model), std::string::npos);
  EXPECT_EQ(scenario.reflector_name, cell.tracker.reflector);

  // The first search must find the reflector wherever the path leads.
  for (const JointVector& q : scenario.stream_path) {
    const Eigen::Vector3d guess =
        cell.tracker.placement * (forward_kinematics(cell.robot.model, q) * cell.reflector.p_FS_mm);
    const Eigen::Vector3d truth = scenario.X_WB * (forward_kinematics(scenario.truth, q) * scenario.p_FS_mm);
    EXPECT_LT((guess - truth).norm(), cell.tracker.search_first_mm);
    EXPECT_GT((guess - truth).norm(), cell.tracker.search_mm);
  }
}

}  // namespace
}  // namespace truepose::config
