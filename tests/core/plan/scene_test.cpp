#include "core/plan/scene.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/random.hpp"
#include "core/plan/candidates.hpp"
#include "tests/core/planning_example.hpp"
#include "tests/core/scene_oracle.hpp"

namespace truepose {
namespace {

using testing::HasSubstr;

Eigen::Vector3d point(Random& random) {
  return {random.uniform(-100, 100), random.uniform(-100, 100), random.uniform(-100, 100)};
}

TEST(Capsules, AreAsFarApartAsTheNearestOfManyPointsOnThem) {
  Random random{1};
  for (int trial = 0; trial < 2000; ++trial) {
    Capsule a{point(random), point(random), random.uniform(0, 30)};
    Capsule b{point(random), point(random), random.uniform(0, 30)};
    if (trial % 5 == 0) b.to_mm = b.from_mm;                                   // a sphere
    if (trial % 7 == 0) a.to_mm = a.from_mm;                                   // another
    if (trial % 11 == 0) b.to_mm = b.from_mm + 0.7 * (a.to_mm - a.from_mm);    // parallel
    if (trial % 13 == 0) b.from_mm = a.from_mm + 0.3 * (a.to_mm - a.from_mm);  // crossing
    const double sampled = test::sampled_distance_mm(a, b, 200);
    EXPECT_LE(distance_mm(a, b), sampled + 1e-9) << trial;
    EXPECT_NEAR(distance_mm(a, b), sampled, 1.0) << trial;
    EXPECT_NEAR(distance_mm(a, b), distance_mm(b, a), 1e-9) << trial;
  }
}

TEST(PoseChecker, TakesAPoseForSeenWhereOneOfSeveralReflectorsIs) {
  Scene a = test::planning_scene();
  Scene b = a;
  b.sight.p_FS_mm = {-80, 60, 180};
  b.sight.facing_F = {-0.7, 0.1, 0.7};
  Scene both = a;
  both.sight.further = {{b.sight.p_FS_mm, b.sight.facing_F, b.sight.acceptance_rad}};
  PoseChecker sees_a{a}, sees_b{b}, sees_both{both};
  Random random{5};
  int by_a = 0, by_b = 0, by_none = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    JointVector q{6};
    for (int i = 0; i < 6; ++i) {
      const Joint& joint = a.robot.joints[static_cast<std::size_t>(i)];
      q[i] = random.uniform(joint.min, joint.max);
    }
    const bool a_seen = !sees_a.seen_at(q).empty(), b_seen = !sees_b.seen_at(q).empty();
    std::vector<int> expected;
    if (a_seen) expected.push_back(0);
    if (b_seen) expected.push_back(1);
    EXPECT_EQ(sees_both.seen_at(q), expected) << trial;
    if (sees_both.fault_of(q, Visibility::Regardless)) continue;
    EXPECT_EQ(!sees_both.fault_of(q), a_seen || b_seen) << trial;
    by_a += a_seen;
    by_b += b_seen;
    by_none += !a_seen && !b_seen;
  }
  EXPECT_GT(by_a, 5);
  EXPECT_GT(by_b, 5);
  EXPECT_GT(by_none, 50);
}

TEST(PoseChecker, AgreesWithAnOracleThatSamplesBodiesAndBeam) {
  Scene scene = test::planning_scene();
  scene.sight.acceptance_rad = 130 * kRadPerDeg;  // or hardly a pose would be judged by more than that
  PoseChecker checker{scene};
  Random random{2};
  int good = 0, beam_cut = 0, itself = 0, obstacle = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    JointVector q{6};
    for (int i = 0; i < 6; ++i) {
      const Joint& joint = scene.robot.joints[static_cast<std::size_t>(i)];
      q[i] = random.uniform(joint.min, joint.max);
    }
    const auto fault = checker.fault_of(q);
    const test::OracleVerdict oracle = test::judge_by_sampling(scene, q);
    // The oracle's points lie some millimetres apart: near a bound it may find what is just clear.
    if (!fault) {
      EXPECT_TRUE(oracle.seen) << trial;
      EXPECT_GT(oracle.clearance_mm, scene.surroundings.clearance_mm - 1) << trial;
      EXPECT_GT(oracle.beam_clearance_mm, scene.sight.beam_radius_mm - 1) << trial;
      ++good;
    } else if (*fault == PoseFault::TurnedAway) {
      EXPECT_FALSE(oracle.seen) << trial;
    } else if (*fault == PoseFault::BeamCut) {
      EXPECT_LT(std::min(oracle.beam_clearance_mm, oracle.mount_clearance_mm + scene.sight.beam_radius_mm),
                scene.sight.beam_radius_mm + 10)
          << trial;
      ++beam_cut;
    } else if (*fault != PoseFault::JointLimit && *fault != PoseFault::SingularWrist) {
      EXPECT_LT(oracle.clearance_mm, scene.surroundings.clearance_mm + 10) << trial << fault_text(*fault);
      itself += *fault == PoseFault::ItselfCollides;
      obstacle += *fault == PoseFault::Obstacle;
    }
  }
  EXPECT_GT(good, 100);
  EXPECT_GT(itself, 10);
  EXPECT_GT(obstacle, 10);
  EXPECT_GT(beam_cut, 10);
}

TEST(PoseChecker, BoundsWhatAMotionUsesUpOfTheClearance) {
  Random random{3};
  for (const JointType first : {JointType::Revolute, JointType::Prismatic}) {
    Scene scene = test::planning_scene();
    if (first == JointType::Prismatic) {
      scene.robot.joints[0].type = first;
      scene.robot.joints[0].min = -2000;
      scene.robot.joints[0].max = 3000;
    }
    PoseChecker checker{scene};
    double largest_share = 0;
    for (int trial = 0; trial < 2000; ++trial) {
      JointVector from{6}, to{6};
      const double length = random.uniform(0, 0.2);
      for (int i = 0; i < 6; ++i) {
        const Joint& joint = scene.robot.joints[static_cast<std::size_t>(i)];
        from[i] = random.uniform(joint.min, joint.max);
        to[i] = from[i] + length * random.uniform(joint.min, joint.max) * (trial % 6 == i || trial % 2 == 0);
      }
      EXPECT_EQ(checker.spare_mm(from) < 0, checker.collision_at(from).has_value()) << trial;
      const double change = std::abs(checker.spare_mm(to) - checker.spare_mm(from));
      const double bound = checker.largest_change_mm(to - from);
      EXPECT_LE(change, bound + 1e-9) << trial;
      largest_share = std::max(largest_share, change / bound);
    }
    EXPECT_GT(largest_share, 0.5);  // a bound that says something
  }
}

TEST(PoseChecker, SeesAnArmThatStandsInItsOwnBeam) {
  Scene scene = test::planning_scene();
  scene.surroundings.obstacles.clear();
  scene.sight.acceptance_rad = std::numbers::pi;
  JointVector q{6};
  q << 0, -90, 90, 0, 0, 0;
  q *= kRadPerDeg;
  // The arm reaches along +x; a tracker far behind it at the same height looks through the arm.
  PoseChecker in_front{(scene.sight.X_WB = Eigen::Isometry3d{Eigen::Translation3d{-6000, 0, -1910}}, scene)};
  EXPECT_EQ(in_front.fault_of(q, Visibility::Required), PoseFault::SingularWrist);
  q[4] = 20 * kRadPerDeg;
  PoseChecker again{scene};
  EXPECT_EQ(again.fault_of(q), std::nullopt);
  scene.sight.X_WB = Eigen::Translation3d{6000, 0, -1910};
  PoseChecker behind{scene};
  EXPECT_EQ(behind.fault_of(q), PoseFault::BeamCut);
  EXPECT_EQ(behind.fault_of(q, Visibility::Regardless), std::nullopt);
}

TEST(PoseChecker, KeepsTheReflectorInTheWorkspace) {
  Scene scene = test::planning_scene();
  scene.workspace = {{1000, -400, 800}, {2000, 400, 1800}};
  const auto drawn = draw_candidates(scene, {.poses = 40}, 40);
  ASSERT_TRUE(drawn) << drawn.error();
  for (const JointVector& q : drawn->poses) {
    EXPECT_TRUE(scene.workspace.holds(forward_kinematics(scene.robot, q) * scene.sight.p_FS_mm));
  }
  EXPECT_GT(drawn->faults[static_cast<std::size_t>(PoseFault::OutsideWorkspace)], 0);
}

TEST(PoseChecker, OfAnArmWithoutABodyKeepsItsJointCentresClear) {
  Scene scene = test::planning_scene();
  scene.body.clear();
  const auto drawn = draw_candidates(scene, {.poses = 100}, 100);
  ASSERT_TRUE(drawn) << drawn.error();
  for (const JointVector& q : drawn->poses) {
    LinkFrames X;
    link_frames(scene.robot, q, X);
    for (std::size_t i = 2; i <= 6; ++i)
      EXPECT_GE(X[i].translation().z(), scene.surroundings.floor_mm + scene.surroundings.clearance_mm);
  }
}

TEST(Candidates, TheSameSeedGivesTheSamePosesAndAnotherSeedOthers) {
  const Scene scene = test::planning_scene();
  const auto first = draw_candidates(scene, {.poses = 20, .seed = 42}, 20);
  const auto again = draw_candidates(scene, {.poses = 20, .seed = 42}, 20);
  const auto other = draw_candidates(scene, {.poses = 20, .seed = 43}, 20);
  ASSERT_TRUE(first && again && other);
  EXPECT_EQ(first->poses, again->poses);
  EXPECT_NE(first->poses, other->poses);
}

TEST(Candidates, SaysWhatMostPosesFailedOnWhenThereAreTooFew) {
  Scene scene = test::planning_scene();
  scene.sight.acceptance_rad = 0.1 * kRadPerDeg;
  const auto turned = draw_candidates(scene, {.poses = 60, .tries = 2000}, 60);
  ASSERT_FALSE(turned);
  EXPECT_THAT(turned.error(), HasSubstr("of 60 poses found in 2000 tries"));
  EXPECT_THAT(turned.error(), HasSubstr("had the reflector turned away from the tracker"));
  scene.sight.acceptance_rad = std::numbers::pi;
  scene.surroundings.floor_mm = 10'000;
  const auto high = draw_candidates(scene, {.poses = 60, .tries = 2000}, 60);
  ASSERT_FALSE(high);
  EXPECT_THAT(high.error(), HasSubstr("came below the floor"));
}

TEST(Candidates, AreNotSoughtToTheLastTryWhereThereIsNoHopeOfEnough) {
  Scene scene = test::planning_scene();
  scene.workspace = {{5000, 5000, 5000}, {6000, 6000, 6000}};
  const auto nowhere = draw_candidates(scene, {.poses = 60, .tries = 100'000}, 60);
  ASSERT_FALSE(nowhere);
  EXPECT_THAT(nowhere.error(), HasSubstr("only 0 of 60 poses found in 20000 tries"));
}

TEST(Candidates, AreSoughtOnWhileThereIsHopeOfEnough) {
  Scene scene = test::planning_scene();
  const auto usual = draw_candidates(scene, {.poses = 400}, 400);
  ASSERT_TRUE(usual);
  ASSERT_GT(usual->tried, 10'000);
  const auto asked = draw_candidates(scene, {.poses = 400, .tries = usual->tried}, 400);
  ASSERT_TRUE(asked);
  EXPECT_EQ(asked->poses, usual->poses);
}

TEST(Candidates, NamesWhatMakesTheSceneUnfit) {
  Scene scene = test::planning_scene();
  scene.limit_margin_rad = 70 * kRadPerDeg;
  EXPECT_THAT(draw_candidates(scene, {}, 1).error(),
              HasSubstr("joint 2: nothing is left between its limits"));
  scene = test::planning_scene();
  scene.sight.p_FS_mm = {3, 4, 190};
  EXPECT_THAT(draw_candidates(scene, {}, 1).error(), HasSubstr("the reflector is 5.0 mm from the last axis"));
  scene = test::planning_scene();
  scene.sight.p_FS_mm = {30, -20, 100};
  EXPECT_THAT(draw_candidates(scene, {}, 1).error(), HasSubstr("the reflector lies inside the tool's body"));
}

}  // namespace
}  // namespace truepose
