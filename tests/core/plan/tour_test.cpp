#include "core/plan/tour.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iostream>
#include <numeric>

#include "core/math/random.hpp"
#include "core/plan/candidates.hpp"
#include "core/step_count.hpp"
#include "tests/core/planning_example.hpp"

namespace truepose {
namespace {

std::vector<JointVector> tour_poses(int count, std::uint64_t seed) {
  return draw_candidates(test::planning_scene(), {.poses = count, .seed = seed}, count)->poses;
}

TourOptions tour_options(int reference_every = 0) {
  return {.start = JointVector::Zero(6),
          .reference = tour_poses(1, 77).front(),
          .reference_every = reference_every};
}

TEST(TravelTime, IsThatOfTheSlowestJoint) {
  RobotModel robot = test::planning_scene().robot;
  for (Joint& joint : robot.joints) joint.speed = 1, joint.acceleration = 0;
  robot.joints[2].speed = 0.5;
  JointVector from = JointVector::Zero(6), to = JointVector::Zero(6);
  to << 0.8, 0, -0.5, 0, 0, 0;
  EXPECT_NEAR(travel_time_s(robot, from, to), 1.0, 1e-12);
}

TEST(TravelTime, SpeedsUpAndSlowsDownByTheAcceleration) {
  RobotModel robot = test::planning_scene().robot;
  for (Joint& joint : robot.joints) joint.speed = 2, joint.acceleration = 4;
  JointVector from = JointVector::Zero(6), to = JointVector::Zero(6);
  to[0] = 0.5;  // too short for full speed: twice sqrt(0.5 / 4)
  EXPECT_NEAR(travel_time_s(robot, from, to), 2 * std::sqrt(0.125), 1e-12);
  to[0] = 5;  // 0.5 s up, 0.5 s down, 1 rad in them, 4 rad at 2 rad/s
  EXPECT_NEAR(travel_time_s(robot, from, to), 3.0, 1e-12);
}

TravelTime travel_time() {
  return [robot = test::planning_scene().robot](const JointVector& from, const JointVector& to) {
    return travel_time_s(robot, from, to);
  };
}

class ToursWithVisits : public testing::TestWithParam<int> {};

TEST_P(ToursWithVisits, HoldEveryPoseOnceAndTheTimeThatTheySay) {
  const auto all = tour_poses(23, 1);
  const RobotModel robot = test::planning_scene().robot;
  const Tour tour =
      shortest_tour({travel_time(), travel_time(), all, tour_options(GetParam())}, tour_options(GetParam()));
  std::vector<std::size_t> sorted = tour.order;
  std::ranges::sort(sorted);
  for (std::size_t i = 0; i < sorted.size(); ++i) EXPECT_EQ(sorted[i], i);
  ASSERT_EQ(sorted.size(), 23u);
  // Driven step by step.
  double time_s = 0;
  JointVector here = JointVector::Zero(6);
  const auto drive = [&](const JointVector& q) {
    time_s += travel_time_s(robot, here, q);
    here = q;
  };
  const TourOptions with = tour_options(GetParam());
  for (std::size_t i = 0; i < tour.order.size(); ++i) {
    if (with.reference_every > 0 && i % static_cast<std::size_t>(with.reference_every) == 0)
      drive(with.reference);
    drive(all[tour.order[i]]);
  }
  if (with.reference_every > 0) drive(with.reference);
  EXPECT_NEAR(tour.time_s, time_s, 1e-9);
  EXPECT_NEAR((TourTimes{travel_time(), travel_time(), all, with}.total(tour.order)), time_s, 1e-9);
}

TEST_P(ToursWithVisits, OfAFewPosesAreTheShortestThereAre) {
  const auto all = tour_poses(7, 2);
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const TourOptions with = tour_options(GetParam());
  const TourTimes times{travel_time(), travel_time(), all, with};
  double shortest_s = 1e9;
  do {
    shortest_s = std::min(shortest_s, times.total(order));
  } while (std::ranges::next_permutation(order).found);
  EXPECT_NEAR(shortest_tour(times, with).time_s, shortest_s, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(ToTheReference, ToursWithVisits, testing::Values(0, 1, 3, 5));

TEST(Tour, LeavesTheLeadingPosesInFront) {
  const auto all = tour_poses(20, 8);
  for (const int every : {0, 4}) {
    TourOptions with = tour_options(every);
    with.first = 6;
    const Tour tour = shortest_tour({travel_time(), travel_time(), all, with}, with);
    for (std::size_t i = 0; i < tour.order.size(); ++i) EXPECT_EQ(tour.order[i] < 6, i < 6);
    EXPECT_GE(
        tour.time_s,
        shortest_tour({travel_time(), travel_time(), all, tour_options(every)}, tour_options(every)).time_s -
            1e-9);
  }
}

/// What it takes to order so many random poses, where every third motion is blocked.
struct Effort {
  std::uint64_t motions = 0;  ///< that are asked for
  std::uint64_t steps = 0;
};

Effort effort_of(std::size_t count, int reference_every) {
  Effort effort;
  const TravelTime direct = travel_time();
  const TravelTime detour = [&](const JointVector& from, const JointVector& to) {
    const bool blocked = effort.motions++ % 3 == 0;
    return blocked ? 2 * direct(from, to) + 3 : direct(from, to);
  };
  Random random{4};
  std::vector<JointVector> all(count, JointVector::Zero(6));
  for (JointVector& q : all)
    for (double& angle : q) angle = random.uniform(-1, 1);
  TourOptions few_kicks = tour_options(reference_every);
  few_kicks.kicks = 100;
  std::atomic<std::uint64_t> steps{0};
  step_count = &steps;
  shortest_tour({detour, direct, all, few_kicks}, few_kicks);
  step_count = nullptr;
  effort.steps = steps;
  return effort;
}

TEST(Tour, TakesEffortInProportionToItsPoses) {
  for (const int every : {0, 10}) {
    const Effort few = effort_of(200, every), many = effort_of(800, every);
    std::cout << "reference every " << every << ": 200 poses " << few.motions << " motions, " << few.steps
              << " steps; 800 poses " << many.motions << " motions, " << many.steps << " steps\n";
    // All motions between the poses are sixteen times as many.
    EXPECT_LE(many.motions, 6 * few.motions);
    EXPECT_LE(many.steps, 6 * few.steps);
  }
}

TEST(Tour, OfNoPoseOrOneIsThatItself) {
  const RobotModel robot = test::planning_scene().robot;
  EXPECT_TRUE(
      shortest_tour({travel_time(), travel_time(), {}, tour_options()}, tour_options()).order.empty());
  const auto one = tour_poses(1, 6);
  const Tour tour = shortest_tour({travel_time(), travel_time(), one, tour_options()}, tour_options());
  EXPECT_EQ(tour.order, std::vector<std::size_t>{0});
  EXPECT_NEAR(tour.time_s, travel_time_s(robot, JointVector::Zero(6), one[0]), 1e-12);
}

}  // namespace
}  // namespace truepose
