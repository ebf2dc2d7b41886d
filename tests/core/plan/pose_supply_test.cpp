#include "core/plan/pose_supply.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/planning_example.hpp"

namespace truepose {
namespace {

PoseSupply supply(int candidates = 300) {
  const PlanOptions options{
      .poses = 24,
      .validate = 10,
      .candidates = candidates,
      .seed = 5,
      .noise = {.tracker = {.range_mm = 0.01, .transverse_mm_per_m = 0.003}, .repeatability_mm = 0.0166},
      .start = JointVector::Zero(6),
      .sizes = {}};
  return *PoseSupply::make(test::planning_cell(), test::planning_scene(), options);
}

Eigen::Vector3d reflector(const JointVector& q) { return test::planning_cell().predict(q, 0); }

TEST(PoseSupply, ReplacesAPoseThatFailsByOneFarFromTheTrouble) {
  PoseSupply poses = supply();
  std::vector<JointVector> used = poses.plan().poses, failed;
  std::vector<std::size_t> kept = poses.plan().chosen;
  for (int round = 0; round < 5; ++round) {
    failed.push_back(used[static_cast<std::size_t>(round)]);
    const auto next = poses.substitute(failed.back());
    ASSERT_TRUE(next);
    EXPECT_EQ(std::ranges::count(used, *next), 0);
    EXPECT_EQ(std::ranges::count(poses.plan().validate, *next), 0);
    for (const JointVector& q : failed) EXPECT_GT((reflector(*next) - reflector(q)).norm(), 150);
    used.push_back(*next);
    kept.erase(kept.begin());
    kept.push_back(static_cast<std::size_t>(std::ranges::find(poses.plan().candidates.poses, *next) -
                                            poses.plan().candidates.poses.begin()));
  }
  // Five substitutes lose little.
  EXPECT_LT(predicted_error(*poses.plan().problem, kept).rms_mm, 1.1 * poses.plan().predicted.rms_mm);
}

TEST(PoseSupply, ReplacesAValidationPoseByAnUnusedNeighbour) {
  PoseSupply poses = supply();
  const JointVector failed = poses.plan().validate.front();
  const auto next = poses.validation_substitute(failed);
  ASSERT_TRUE(next);
  EXPECT_EQ(std::ranges::count(poses.plan().poses, *next), 0);
  EXPECT_EQ(std::ranges::count(poses.plan().validate, *next), 0);
  EXPECT_GT((reflector(*next) - reflector(failed)).norm(), 150);
  EXPECT_LT((reflector(*next) - reflector(failed)).norm(), 600);
}

TEST(PoseSupply, GoesOnWithAnEarlierPlanAsIfItHadNeverEnded) {
  PoseSupply first = supply();
  const JointVector lost = first.plan().poses[3], unseen = first.plan().validate[2];
  const JointVector by = first.substitute(lost).value(), near = first.validation_substitute(unseen).value();

  const PlanOptions options{
      .poses = 24,
      .validate = 10,
      .candidates = 300,
      .seed = 5,
      .noise = {.tracker = {.range_mm = 0.01, .transverse_mm_per_m = 0.003}, .repeatability_mm = 0.0166},
      .sizes = {}};
  PoseSupply again = *PoseSupply::again(test::planning_cell(), test::planning_scene(), options,
                                        {first.plan().poses, first.plan().validate, {}});
  EXPECT_EQ(again.plan().poses, first.plan().poses);
  EXPECT_EQ(again.plan().validate, first.plan().validate);
  EXPECT_EQ(again.plan().chosen, first.plan().chosen);
  again.replaced(lost, by);
  again.replaced(unseen, near);
  for (const std::size_t next : {5U, 8U}) {
    EXPECT_EQ(again.substitute(again.plan().poses[next]), first.substitute(first.plan().poses[next]));
    EXPECT_EQ(again.validation_substitute(again.plan().validate[next]),
              first.validation_substitute(first.plan().validate[next]));
  }
}

TEST(PoseSupply, TakesPosesOfAnEarlierPlanThatAreNoCandidatesAnyMore) {
  const JointVector q = supply().plan().poses.front() + JointVector::Constant(6, 0.01);
  const PlanOptions options{.poses = 1, .candidates = 60, .seed = 7, .sizes = {}};
  PoseSupply again =
      *PoseSupply::again(test::planning_cell(), test::planning_scene(), options, {{q}, {}, {}});
  EXPECT_EQ(again.plan().poses, std::vector{q});
  EXPECT_TRUE(again.substitute(q));
}

TEST(PoseSupply, HasNoSubstituteOnceAllThatIsLeftIsNearTrouble) {
  PoseSupply poses = supply(60);
  int replaced = 0;
  for (std::optional<JointVector> next = poses.plan().poses.front(); next; ++replaced)
    next = poses.substitute(*next);
  EXPECT_GT(replaced, 3);
  EXPECT_LT(replaced, 60);
}

TEST(PoseSupply, LeadsFromEveryPoseToTheNext) {
  PoseSupply poses = supply();
  MotionChecker motion{test::planning_scene()};
  JointVector here = poses.plan().poses.front();
  for (const JointVector& q : poses.plan().poses) {
    const auto way = poses.way(here, q);
    ASSERT_TRUE(way);
    for (const JointVector& via : *way) {
      EXPECT_TRUE(motion.clear(here, via));
      here = via;
    }
    EXPECT_TRUE(motion.clear(here, q));
    here = q;
  }
}

}  // namespace
}  // namespace truepose
