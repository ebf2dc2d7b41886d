#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>

#include "core/calibration/calibrate.hpp"
#include "core/planning/measurement_plan.hpp"
#include "core/planning/tour.hpp"
#include "core/simulation/measurement_campaign.hpp"
#include "core/simulation/published_errors.hpp"
#include "tests/core/planning_example.hpp"

namespace truepose {
namespace {

TEST(Tour, IsWithinThreePercentOfOneSearchedAHundredTimesLonger) {
  const TravelTime time = [robot = test::planning_scene().robot](const JointVector& from,
                                                                 const JointVector& to) {
    return travel_time_s(robot, from, to);
  };
  for (const std::uint64_t seed : {3u, 4u, 5u}) {
    const auto all = draw_candidates(test::planning_scene(), {.poses = 50, .seed = seed}, 50)->poses;
    TourOptions quick{.start = JointVector::Zero(6)}, longer = quick;
    quick.kicks = 300;
    longer.kicks = 100 * quick.kicks;
    longer.seed = 99;
    const double quick_s = shortest_tour({time, all, quick}, quick).time_s;
    const double longer_s = shortest_tour({time, all, longer}, longer).time_s;
    std::printf("tour %.2f s, searched a hundred times longer %.2f s\n", quick_s, longer_s);
    EXPECT_LT(quick_s, 1.03 * longer_s) << seed;
  }
}

/// Errors of a fit at the poses of a task.
struct Judged {
  double rmse_mm = 0, worst_mm = 0;
};

Judged judged(const CalibratedCell& truth, const std::vector<JointVector>& measured,
              const std::vector<JointVector>& elsewhere, std::uint64_t seed) {
  const TrueArmSetup arm{.robot = truth.robot,
                         .X_WB = truth.base.isometry(),
                         .p_FS_mm = truth.reflectors[0].p_FS_mm,
                         .repeatability_mm = kRepeatability_mm};
  const auto data = measure_campaign(arm, measured, {}, {.seed = seed}).data;
  const auto fit =
      calibrate(test::planning_scene().robot, data, {.prior = PriorUse::Off, .check_model = false});
  Judged errors;
  for (const JointVector& q : elsewhere) {
    const double off_mm = (fit->cell.predict(q, 0) - truth.predict(q, 0)).norm();
    errors.rmse_mm += off_mm * off_mm / static_cast<double>(elsewhere.size());
    errors.worst_mm = std::max(errors.worst_mm, off_mm);
  }
  errors.rmse_mm = std::sqrt(errors.rmse_mm);
  return errors;
}

/// Thirty poses over all seeds.
struct Thirty {
  double rmse_mm = 0;        ///< of the fits
  double mean_worst_mm = 0;  ///< of the fits: the worst point of each seed, their mean
  double worst_mm = 0;       ///< standard deviation of the worst point of all seeds
};

void print(const char* where, const Thirty& planned, const Thirty& random) {
  std::printf(
      "%s: RMSE %.4f against %.4f mm (%.0f %% lower), worst of all seeds %.4f against %.4f (%.0f %% lower), "
      "mean worst of the fits %.4f against %.4f\n",
      where, planned.rmse_mm, random.rmse_mm, 100 * (1 - planned.rmse_mm / random.rmse_mm), planned.worst_mm,
      random.worst_mm, 100 * (1 - planned.worst_mm / random.worst_mm), planned.mean_worst_mm,
      random.mean_worst_mm);
}

// The arm of the paper, validated over the whole workspace, for which is planned, and as a campaign can: at
// other poses that the tracker sees.
TEST(PlannedPoses, OfThirtyPredictAFifthBetterThanRandomOnesAndTheirWorstPointByTwoFifths) {
  const Scene scene = test::planning_scene();
  CalibratedCell truth = test::planning_cell();
  truth.robot = with_published_errors(scene.robot);
  const MeasurementNoise noise{.tracker = {.range_mm = kTrackerNoise_mm, .transverse_mm = kTrackerNoise_mm},
                               .repeatability_mm = kRepeatability_mm};
  constexpr int kSeeds = 100;
  Thirty planned, random, planned_visible, random_visible;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const auto candidates = draw_candidates(scene, {.poses = 2000, .seed = seed}, 2000);
    const auto task = draw_task(scene, {}, seed), workspace = draw_task(scene, {}, seed + 1'000'000);
    const auto visible = draw_candidates(scene, {.poses = 400, .seed = seed + 1'000'000}, 400);
    ASSERT_TRUE(candidates && task && workspace && visible);
    const DesignProblem problem{test::planning_cell(), candidates->poses, *task, noise};
    const auto judge = [&](Thirty& of, const std::vector<std::size_t>& chosen,
                           const std::vector<JointVector>& at) {
      std::vector<JointVector> poses;
      for (const std::size_t k : chosen) poses.push_back(candidates->poses[k]);
      const Judged fit = judged(truth, poses, at, seed);
      of.rmse_mm += fit.rmse_mm / kSeeds;
      of.mean_worst_mm += fit.worst_mm / kSeeds;
      const DesignProblem validation{test::planning_cell(), candidates->poses, at, noise};
      of.worst_mm = std::max(of.worst_mm, predicted_error(validation, chosen).max_mm);
    };
    const auto design = optimal_design(problem, {.poses = 30, .seed = seed});
    std::vector<std::size_t> first(30);
    std::iota(first.begin(), first.end(), std::size_t{0});
    judge(planned, design, *workspace);
    judge(random, first, *workspace);
    judge(planned_visible, design, visible->poses);
    judge(random_visible, first, visible->poses);
  }
  print("workspace", planned, random);
  print("visible", planned_visible, random_visible);
  EXPECT_LT(planned.rmse_mm, 0.80 * random.rmse_mm);
  EXPECT_LT(planned.worst_mm, 0.60 * random.worst_mm);
  EXPECT_LT(planned_visible.rmse_mm, 0.82 * random_visible.rmse_mm);
  EXPECT_LT(planned_visible.worst_mm, 0.60 * random_visible.worst_mm);
}

}  // namespace
}  // namespace truepose
