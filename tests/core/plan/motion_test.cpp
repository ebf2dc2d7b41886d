#include "core/plan/motion.hpp"

#include <gtest/gtest.h>

#include "core/plan/candidates.hpp"
#include "tests/core/planning_example.hpp"
#include "tests/core/scene_oracle.hpp"

namespace truepose {
namespace {

/// Nothing stands about the arm but a pillar in front of it.
Scene pillar_scene() {
  Scene scene = test::planning_scene();
  scene.surroundings.obstacles = {{{1500, 0, 0}, {1500, 0, 2500}, 150}};
  return scene;
}

JointVector reaching(double a1_deg) {
  JointVector q{6};
  q << a1_deg, -60, 60, 0, 30, 0;
  return q * kRadPerDeg;
}

JointVector folded(double a1_deg) {
  JointVector q{6};
  q << a1_deg, -130, 110, 0, -30, 0;
  return q * kRadPerDeg;
}

/// The least clearance on a motion, judged every tenth of a degree or so.
double least_clearance_mm(const Scene& scene, const JointVector& from, const JointVector& to) {
  double least = 1e9;
  for (int i = 0; i <= 300; ++i)
    least = std::min(least, test::judge_by_sampling(scene, from + i / 300.0 * (to - from)).clearance_mm);
  return least;
}

TEST(Motion, ThroughAnObstacleIsNotClear) {
  MotionChecker motion{pillar_scene()};
  ASSERT_GT(test::judge_by_sampling(pillar_scene(), reaching(-40)).clearance_mm, 50);
  ASSERT_GT(test::judge_by_sampling(pillar_scene(), reaching(40)).clearance_mm, 50);
  EXPECT_LT(least_clearance_mm(pillar_scene(), reaching(-40), reaching(40)), 0);
  EXPECT_FALSE(motion.clear(reaching(-40), reaching(40)));
  EXPECT_FALSE(motion.clear(reaching(40), reaching(-40)));
  EXPECT_TRUE(motion.clear(reaching(40), reaching(100)));
}

TEST(Motion, GoesRoundByStopoversThatAreClearAllTheWay) {
  MotionChecker motion{pillar_scene()};
  const std::vector<JointVector> stopovers{reaching(0), folded(-40), folded(40), folded(0)};
  const auto way = motion.way(reaching(-40), reaching(40), stopovers);
  ASSERT_TRUE(way);
  ASSERT_FALSE(way->empty());
  JointVector here = reaching(-40);
  std::vector<JointVector> stops = *way;
  stops.push_back(reaching(40));
  for (const JointVector& next : stops) {
    EXPECT_GT(least_clearance_mm(pillar_scene(), here, next), 0);
    here = next;
  }
}

TEST(Motion, NeedsNoStopoverWhereItIsClear) {
  MotionChecker motion{pillar_scene()};
  const auto way = motion.way(reaching(40), reaching(100), std::vector{folded(0)});
  ASSERT_TRUE(way);
  EXPECT_TRUE(way->empty());
}

TEST(Motion, SaysWhereNoWayLeads) {
  MotionChecker motion{pillar_scene()};
  EXPECT_FALSE(motion.way(reaching(-40), reaching(40), {}));
  EXPECT_FALSE(motion.way(reaching(-40), reaching(40), std::vector{reaching(0), reaching(-60)}));
}

TEST(Motion, LeavesAPlaceThatIsNotClearItself) {
  Scene scene = pillar_scene();
  scene.surroundings.clearance_mm = 10;
  MotionChecker motion{scene};
  ASSERT_TRUE(PoseChecker{scene}.collision_at(reaching(0)));
  EXPECT_TRUE(motion.clear(reaching(0), reaching(60)));
}

/// The first a1 from -40 deg at which the reaching arm is nearer to the obstacles than that.
double standing_near_deg(const Scene& scene, double clearance_mm) {
  double a1_deg = -40;
  while (test::judge_by_sampling(scene, reaching(a1_deg)).clearance_mm > clearance_mm) a1_deg += 0.05;
  return a1_deg;
}

TEST(Motion, FromWithinTheClearanceItGoesAwayAndNotThroughTheObstacle) {
  for (const double radius_mm : {150.0, 5.0}) {
    Scene scene = pillar_scene();
    scene.surroundings.obstacles.front().radius_mm = radius_mm;
    MotionChecker motion{scene};
    const double near_deg = standing_near_deg(scene, 20);
    ASSERT_TRUE(PoseChecker{scene}.collision_at(reaching(near_deg)));
    EXPECT_TRUE(motion.clear(reaching(near_deg), reaching(near_deg - 40)));
    EXPECT_FALSE(motion.clear(reaching(near_deg), reaching(40)));
    // Nor does it come to such a place from the other side.
    EXPECT_TRUE(motion.clear(reaching(near_deg - 40), reaching(near_deg)));
    EXPECT_FALSE(motion.clear(reaching(40), reaching(near_deg)));
  }
}

}  // namespace
}  // namespace truepose
