#include "core/plan/test_cube_poses.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "core/plan/motion.hpp"
#include "tests/core/planning_example.hpp"

namespace truepose {
namespace {

/// The reflector of the scene's arm in its base.
Eigen::Vector3d reflector_at(const Scene& scene, const JointVector& q) {
  return forward_kinematics(scene.robot, q) * scene.sight.p_FS_mm;
}

void expect_measurable(const TestCubePoses& poses, const Scene& scene) {
  PoseChecker checker{scene};
  for (std::size_t i = 0; i < poses.q.size(); ++i) {
    EXPECT_FALSE(checker.fault_of(poses.q[i])) << "P" << i + 1;
    EXPECT_LT((reflector_at(scene, poses.q[i]) - poses.p_B_mm[i]).norm(), 1e-6);
    const Eigen::Matrix3d R_BF = forward_kinematics(scene.robot, poses.q[i]).linear();
    EXPECT_LT((R_BF - poses.R_BF).norm(), 1e-9) << "all in one orientation";
  }
}

TEST(TestCubePlacement, FindsFivePosesThatTheTrackerSees) {
  const Scene scene = test::planning_scene();
  const auto poses = place_test_cube(scene, {});
  ASSERT_TRUE(poses) << poses.error();
  expect_measurable(*poses, scene);
  EXPECT_GE(poses->cube.edge_mm, 400);
}

TEST(TestCubePlacement, IsInFrontOfTheArmWhereOneFitsThere) {
  Scene scene = test::planning_scene();
  const auto front = place_test_cube(scene, {});
  ASSERT_TRUE(front) << front.error();
  EXPECT_GT(front->cube.X_BC.translation().x(), 0);
  // A task behind the arm is not given up for that.
  const Box task{{-2600, -1500, 300}, {-700, 1500, 2000}};
  scene.sight.X_WB = pose_from_kuka({-3420, 430, -1230}, {166, 0, 0});
  const auto behind = place_test_cube(scene, {.task = task});
  ASSERT_TRUE(behind) << behind.error();
  EXPECT_TRUE(task.holds(behind->cube.X_BC.translation()));
}

TEST(TestCubePlacement, KeepsToWhatIsAskedFor) {
  const Scene scene = test::planning_scene();
  const auto any = place_test_cube(scene, {});
  ASSERT_TRUE(any) << any.error();
  const TestCubeRequest request{.centre_mm = any->cube.X_BC.translation() + Eigen::Vector3d{5, 5, 5},
                                .edge_mm = 200,
                                .orientation = any->R_BF,
                                .plane = DiagonalPlane::C3C4C5C6};
  const auto poses = place_test_cube(scene, request);
  ASSERT_TRUE(poses) << poses.error();
  expect_measurable(*poses, scene);
  EXPECT_EQ(poses->p_B_mm[0], *request.centre_mm);
  EXPECT_EQ(poses->R_BF, any->R_BF);
  EXPECT_EQ(poses->p_B_mm, test_positions(poses->cube, DiagonalPlane::C3C4C5C6));
}

TEST(TestCubePlacement, PutsTheCentreWhereTheTaskIs) {
  const Scene scene = test::planning_scene();
  const Box task{{1000, -700, 400}, {2000, 700, 1800}};
  const auto poses = place_test_cube(scene, {.task = task});
  ASSERT_TRUE(poses) << poses.error();
  EXPECT_TRUE(task.holds(poses->cube.X_BC.translation()));
  expect_measurable(*poses, scene);
}

TEST(TestCubePlacement, FindsClearWaysAlongTheThreeAxesToThreePoints) {
  const Scene scene = test::planning_scene();
  const auto poses = place_test_cube(scene, {.approach_mm = 100});
  ASSERT_TRUE(poses) << poses.error();
  expect_measurable(*poses, scene);
  PoseChecker checker{scene};
  MotionChecker motion{scene};
  std::vector<std::pair<std::size_t, int>> found;
  for (const PointApproach& approach : poses->approaches) {
    found.emplace_back(approach.point, approach.axis);
    const Eigen::Vector3d way = poses->p_B_mm[approach.point] - reflector_at(scene, approach.q_start);
    const double along_mm = approach.upwards ? 100 : -100;
    EXPECT_LT((way - along_mm * Eigen::Vector3d::Unit(approach.axis)).norm(), 1e-6);
    EXPECT_FALSE(checker.collision_at(approach.q_start));
    EXPECT_TRUE(motion.clear(approach.q_start, poses->q[approach.point]));
    EXPECT_LT((approach.q_start - poses->q[approach.point]).cwiseAbs().maxCoeff(), 0.5) << "one branch";
  }
  EXPECT_THAT(found, testing::ElementsAre(std::pair(3, 0), std::pair(3, 1), std::pair(3, 2), std::pair(1, 0),
                                          std::pair(1, 1), std::pair(1, 2), std::pair(0, 0), std::pair(0, 1),
                                          std::pair(0, 2)));
  EXPECT_TRUE(place_test_cube(scene, {})->approaches.empty());
}

TEST(TestCubePlacement, IsTheSameForTheSameSeed) {
  const Scene scene = test::planning_scene();
  const auto once = place_test_cube(scene, {.seed = 4}), again = place_test_cube(scene, {.seed = 4});
  ASSERT_TRUE(once && again);
  EXPECT_EQ(once->q, again->q);
}

TEST(TestCubePlacement, SaysWhatDoesNotFit) {
  const auto none =
      place_test_cube(test::planning_scene(), {.centre_mm = Eigen::Vector3d{0, 0, 4000}, .edge_mm = 800});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().find("an edge of 800 mm at this centre"), std::string::npos) << none.error();
}

}  // namespace
}  // namespace truepose
