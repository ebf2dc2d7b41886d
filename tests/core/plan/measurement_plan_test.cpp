#include "core/plan/measurement_plan.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/plan/tour.hpp"
#include "tests/core/planning_example.hpp"
#include "tests/core/scene_oracle.hpp"

namespace truepose {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

PlanOptions options() {
  return {.poses = 24,
          .candidates = 300,
          .seed = 5,
          .noise = {.tracker = {.range_mm = 0.01, .transverse_mm_per_m = 0.003}, .repeatability_mm = 0.0166},
          .start = JointVector::Zero(6),
          .sizes = {15, 24, 60}};
}

std::expected<MeasurementPlan, std::string> plan(const PlanOptions& options) {
  return plan_measurements(test::planning_cell(), test::planning_scene(), options);
}

TEST(MeasurementPlan, HoldsDistinctPosesThatAreClearAndSeen) {
  const auto planned = plan(options());
  ASSERT_TRUE(planned) << planned.error();
  ASSERT_EQ(planned->poses.size(), 24u);
  const Scene scene = test::planning_scene();
  for (std::size_t i = 0; i < planned->poses.size(); ++i) {
    const JointVector& q = planned->poses[i];
    EXPECT_EQ(q, planned->candidates.poses[planned->chosen[i]]);
    EXPECT_EQ(std::ranges::count(planned->poses, q), 1);
    EXPECT_TRUE(within_limits(scene.robot, q));
    const test::OracleVerdict verdict = test::judge_by_sampling(scene, q);
    EXPECT_TRUE(verdict.seen);
    EXPECT_GT(verdict.clearance_mm, scene.surroundings.clearance_mm - 1);
    EXPECT_GT(verdict.beam_clearance_mm, scene.sight.beam_radius_mm - 1);
    EXPECT_GT(verdict.mount_clearance_mm, 0);
  }
}

TEST(MeasurementPlan, TellsHowFarItIsAndIsTheSamePlan) {
  std::vector<std::string> steps;
  double last = 0;
  PlanOptions watched = options();
  watched.progress = [&](double share, std::string_view doing) {
    if (steps.empty() || steps.back() != doing) {
      steps.emplace_back(doing);
      last = 0;
    }
    EXPECT_GE(share, last) << doing;
    EXPECT_LE(share, 1) << doing;
    last = share;
  };
  const auto planned = plan(watched), silent = plan(options());
  ASSERT_TRUE(planned && silent);
  EXPECT_THAT(steps, ElementsAre("choice of the poses", "motions between the poses",
                                 "search for the shortest order"));
  EXPECT_GT(last, 0.9);
  EXPECT_EQ(planned->poses, silent->poses);
}

TEST(MeasurementPlan, PromisesLessErrorAndLessTravelThanRandomPoses) {
  const auto planned = plan(options());
  ASSERT_TRUE(planned) << planned.error();
  EXPECT_LT(planned->predicted.rms_mm, 0.8 * planned->random.rms_mm);
  EXPECT_LT(planned->predicted.max_mm, 0.7 * planned->random.max_mm);
  EXPECT_LT(planned->travel_s, 0.8 * planned->random_travel_s);
}

TEST(MeasurementPlan, TurnsTheFlangeAsDifferentlyAsItIsSeenWhereThatIsWanted) {
  PlanOptions turned = options();
  turned.poses = 10;
  const auto nearest_rad = [&](const std::vector<JointVector>& poses) {
    double least = 10;
    for (std::size_t i = 0; i < poses.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const auto R = [&](std::size_t n) -> Eigen::Matrix3d {
          return forward_kinematics(test::planning_scene().robot, poses[n]).linear();
        };
        least = std::min(least, Eigen::AngleAxisd(R(i).transpose() * R(k)).angle());
      }
    return least;
  };
  const double by_parameters = nearest_rad(plan(turned)->poses);
  turned.by_orientation = true;
  const auto planned = plan(turned);
  ASSERT_TRUE(planned) << planned.error();
  EXPECT_EQ(planned->poses.size(), 10u);
  EXPECT_GT(nearest_rad(planned->poses), 0.5);
  EXPECT_GT(nearest_rad(planned->poses), 1.5 * by_parameters);
}

TEST(MeasurementPlan, SaysHowTheErrorFallsWithTheNumberOfPoses) {
  const auto planned = plan(options());
  ASSERT_TRUE(planned) << planned.error();
  ASSERT_EQ(planned->sizes.size(), 3u);
  EXPECT_GT(planned->sizes[0].error.rms_mm, planned->sizes[1].error.rms_mm);
  EXPECT_GT(planned->sizes[1].error.rms_mm, planned->sizes[2].error.rms_mm);
  EXPECT_NEAR(planned->sizes[1].error.rms_mm, planned->predicted.rms_mm, 0.03 * planned->predicted.rms_mm);
}

TEST(MeasurementPlan, ServesTheTaskThatItIsGiven) {
  PlanOptions narrow = options();
  narrow.task = {{1200, -400, 600}, {2000, 400, 1400}};
  const auto for_task = plan(narrow), for_all = plan(options());
  ASSERT_TRUE(for_task && for_all);
  const auto task = draw_task(test::planning_scene(), narrow.task, 9);
  ASSERT_TRUE(task) << task.error();
  const DesignProblem judge{test::planning_cell(), for_all->candidates.poses, *task, narrow.noise};
  EXPECT_LT(predicted_error(judge, for_task->chosen).rms_mm, predicted_error(judge, for_all->chosen).rms_mm);
}

TEST(MeasurementPlan, VisitsAReferencePoseThatIsNearTheOthers) {
  PlanOptions with = options();
  with.reference_every = 6;
  const auto planned = plan(with), without = plan(options());
  ASSERT_TRUE(planned && without);
  ASSERT_TRUE(planned->reference);
  EXPECT_FALSE(without->reference);
  EXPECT_GT(planned->travel_s, without->travel_s);
}

TEST(MeasurementPlan, MeasuresFirstWhatTellsMost) {
  PlanOptions with = options();
  with.first = 8;
  const auto planned = plan(with);
  ASSERT_TRUE(planned) << planned.error();
  const auto volume = [&](std::size_t begin) {
    Design design{*planned->problem, DesignCriterion::D};
    for (std::size_t i = begin; i < begin + 8; ++i) design.add(planned->chosen[i]);
    return design.cost();
  };
  for (std::size_t begin = 8; begin <= 16; ++begin) EXPECT_LT(volume(0), volume(begin));
}

TEST(MeasurementPlan, ValidatesOnPosesThatItDoesNotIdentifyFrom) {
  PlanOptions with = options();
  with.validate = 10;
  const auto planned = plan(with);
  ASSERT_TRUE(planned) << planned.error();
  ASSERT_EQ(planned->validate.size(), 10u);
  for (const JointVector& q : planned->validate) {
    EXPECT_EQ(std::ranges::count(planned->poses, q), 0);
    EXPECT_EQ(std::ranges::count(planned->validate, q), 1);
    EXPECT_EQ(std::ranges::count(planned->candidates.poses, q), 1);
  }
}

TEST(MeasurementPlan, ValidatesByReflectorsThatItIdentifies) {
  CalibratedCell cell = test::planning_cell();
  cell.reflectors.push_back({"2", {-70, 40, 180}});
  Scene scene = test::planning_scene();
  scene.sight.further = {{{-70, 40, 180}, {-0.6, 0.4, 0.7}, scene.sight.acceptance_rad / 2}};
  PoseChecker checker{scene};
  int left_out = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    PlanOptions few = options();
    few.seed = seed;
    few.poses = 12;
    few.validate = 20;
    const auto planned = plan_measurements(cell, scene, few);
    ASSERT_TRUE(planned) << planned.error();
    std::map<int, int> identified;
    for (const JointVector& q : planned->poses) ++identified[checker.seen_at(q).front()];
    left_out += identified[1] < 3;
    for (const JointVector& q : planned->validate) EXPECT_GE(identified[checker.seen_at(q).front()], 3);
  }
  EXPECT_GT(left_out, 0) << "else this proves nothing";
}

TEST(MeasurementPlan, SaysWhyTheSceneLeavesTooFewPoses) {
  Scene scene = test::planning_scene();
  scene.workspace = {{5000, 5000, 5000}, {6000, 6000, 6000}};
  const auto nowhere = plan_measurements(test::planning_cell(), scene, options());
  ASSERT_FALSE(nowhere);
  EXPECT_THAT(nowhere.error(), HasSubstr("left the workspace"));
  PlanOptions far = options();
  far.task = scene.workspace;
  const auto no_task = plan(far);
  ASSERT_FALSE(no_task);
  EXPECT_THAT(no_task.error(), HasSubstr("the task region: only 0 of"));
}

}  // namespace
}  // namespace truepose
