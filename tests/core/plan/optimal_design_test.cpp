#include "core/plan/optimal_design.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/math/random.hpp"
#include "core/plan/optimal_design.hpp"
#include "core/quality/cramer_rao.hpp"
#include "core/simulate/measurement_campaign.hpp"
#include "tests/core/planning_example.hpp"

namespace truepose {
namespace {

constexpr MeasurementNoise kDesignNoise{.tracker = {.range_mm = 0.01, .transverse_mm_per_m = 0.003},
                                        .repeatability_mm = 0.0166};

std::vector<JointVector> poses(int count, std::uint64_t seed) {
  Random random{seed};
  return random_poses(test::planning_cell().robot, count, random);
}

DesignProblem problem(int candidates, std::uint64_t seed) {
  return {test::planning_cell(), poses(candidates, seed), poses(100, seed + 1000), kDesignNoise};
}

Eigen::MatrixXd covariance(const DesignProblem& problem, const std::vector<std::size_t>& chosen) {
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(problem.parameters(), problem.parameters());
  for (const std::size_t k : chosen) M += problem.rows(k).transpose() * problem.rows(k);
  return M.inverse();
}

/// What a criterion says of a design, computed from nothing.
double cost(const DesignProblem& problem, DesignCriterion criterion, const std::vector<std::size_t>& chosen) {
  const Eigen::MatrixXd C = covariance(problem, chosen);
  if (criterion == DesignCriterion::D) return std::log(C.determinant());
  return criterion == DesignCriterion::A ? C.trace() : (problem.task() * C).trace();
}

class EveryCriterion : public testing::TestWithParam<DesignCriterion> {};

TEST_P(EveryCriterion, GainsAreWhatEachCandidateWouldBring) {
  const DesignProblem p = problem(45, 1);
  Design design{p, GetParam()};
  for (const std::size_t k : {3u, 17u, 40u, 8u, 25u, 31u, 2u, 44u, 12u, 20u, 5u, 38u}) design.add(k);
  design.remove(40);
  design.remove(3);
  const double before = cost(p, GetParam(), design.chosen());
  EXPECT_NEAR(design.cost(), before, 1e-6 * std::abs(before));
  const std::vector<double> gains(design.gains().begin(), design.gains().end());
  ASSERT_EQ(gains.size(), 45u);
  for (std::size_t k = 0; k < gains.size(); ++k) {
    if (design.has(k)) continue;
    std::vector<std::size_t> with = design.chosen();
    with.push_back(k);
    const double fall = before - cost(p, GetParam(), with);
    EXPECT_NEAR(GetParam() == DesignCriterion::D ? std::log(gains[k]) : gains[k], fall,
                1e-5 * std::abs(fall) + 1e-9 * std::abs(before))
        << k;
  }
}

TEST_P(EveryCriterion, RefreshingChangesNothingButRounding) {
  const DesignProblem p = problem(45, 2);
  Design design{p, GetParam()};
  for (const std::size_t k : {3u, 17u, 40u, 8u, 25u, 31u, 2u, 44u, 12u, 20u, 5u, 38u}) design.add(k);
  const std::vector<double> before(design.gains().begin(), design.gains().end());
  design.refresh();
  for (std::size_t k = 0; k < before.size(); ++k) EXPECT_NEAR(design.gains()[k], before[k], 1e-4 * before[k]);
}

TEST_P(EveryCriterion, NoExchangeOfOnePoseBettersADesign) {
  const DesignProblem p = problem(60, 3);
  const auto chosen = optimal_design(p, {.criterion = GetParam(), .poses = 12});
  const double best = cost(p, GetParam(), chosen);
  for (std::size_t slot = 0; slot < chosen.size(); ++slot) {
    for (std::size_t other = 0; other < p.candidates(); ++other) {
      if (std::ranges::binary_search(chosen, other)) continue;
      auto exchanged = chosen;
      exchanged[slot] = other;
      ASSERT_GE(cost(p, GetParam(), exchanged), best - 1e-7 * std::abs(best));
    }
  }
}

TEST_P(EveryCriterion, IsServedBestByItsOwnDesign) {
  const DesignProblem p = problem(300, 4);
  const double own = cost(p, GetParam(), optimal_design(p, {.criterion = GetParam(), .poses = 30}));
  for (const DesignCriterion other : {DesignCriterion::D, DesignCriterion::A, DesignCriterion::I}) {
    if (other == GetParam()) continue;
    EXPECT_LT(own, cost(p, GetParam(), optimal_design(p, {.criterion = other, .poses = 30})));
  }
}

INSTANTIATE_TEST_SUITE_P(OfADesign, EveryCriterion,
                         testing::Values(DesignCriterion::D, DesignCriterion::A, DesignCriterion::I),
                         [](const auto& one) { return std::string(1, "DAI"[static_cast<int>(one.param)]); });

TEST(ErrorBound, LiesBelowEveryChoiceOfPosesButNotFarBelowTheBest) {
  const DesignProblem p = problem(16, 12);
  PredictedError best{.rms_mm = 1e9, .max_mm = 1e9};
  std::vector<int> take(p.candidates());
  std::fill_n(take.begin(), 13, 1);
  do {
    std::vector<std::size_t> chosen;
    for (std::size_t k = 0; k < take.size(); ++k)
      if (take[k] == 1) chosen.push_back(k);
    const PredictedError error = predicted_error(p, chosen);
    best = {std::min(best.rms_mm, error.rms_mm), std::min(best.max_mm, error.max_mm)};
  } while (std::ranges::prev_permutation(take).found);
  const PredictedError bound = error_bound(p, 13);
  EXPECT_LE(bound.rms_mm, best.rms_mm);
  EXPECT_LE(bound.max_mm, best.max_mm);
  EXPECT_GT(bound.rms_mm, 0.8 * best.rms_mm);
  EXPECT_GT(bound.max_mm, 0.8 * best.max_mm);
}

TEST(ErrorBound, IsTheErrorWhereAllCandidatesAreMeasured) {
  const DesignProblem p = problem(30, 13);
  std::vector<std::size_t> all(30);
  std::iota(all.begin(), all.end(), std::size_t{0});
  const PredictedError error = predicted_error(p, all), bound = error_bound(p, 30);
  EXPECT_NEAR(bound.rms_mm, error.rms_mm, 1e-9 * error.rms_mm);
  EXPECT_LE(bound.max_mm, error.max_mm);
  EXPECT_GT(bound.max_mm, 0.98 * error.max_mm);
}

TEST(GreedyDesign, TakesTheGreatestDeterminantAtEveryStep) {
  const DesignProblem p = problem(70, 5);
  Design design{p, DesignCriterion::D};
  add_greedily(design, 14);
  std::vector<std::size_t> naive;
  while (naive.size() < 14) {
    std::size_t best = 0;
    double best_cost = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < p.candidates(); ++k) {
      if (std::ranges::find(naive, k) != naive.end()) continue;
      naive.push_back(k);
      if (const double c = cost(p, DesignCriterion::D, naive); c < best_cost) {
        best = k;
        best_cost = c;
      }
      naive.pop_back();
    }
    naive.push_back(best);
  }
  EXPECT_EQ(design.chosen(), naive);
}

TEST(OptimalDesign, ChoosesDistinctPosesThatPredictBetterThanRandomOnes) {
  const DesignProblem p = problem(400, 6);
  const auto chosen = optimal_design(p, {.poses = 30});
  ASSERT_EQ(chosen.size(), 30u);
  EXPECT_EQ(std::ranges::adjacent_find(chosen), chosen.end());
  std::vector<std::size_t> random(30);
  for (std::size_t i = 0; i < random.size(); ++i) random[i] = i;
  EXPECT_LT(predicted_error(p, chosen).rms_mm, 0.85 * predicted_error(p, random).rms_mm);
  EXPECT_LT(predicted_error(p, chosen).max_mm, 0.85 * predicted_error(p, random).max_mm);
}

TEST(OptimalDesign, TheSameSeedGivesTheSameDesign) {
  const DesignProblem p = problem(100, 7);
  EXPECT_EQ(optimal_design(p, {.seed = 3}), optimal_design(p, {.seed = 3}));
}

TEST(OptimalDesign, ReadingsFromAfarWeighLess) {
  CalibratedCell cell = test::planning_cell();
  const auto at = poses(1, 8);
  cell.base.p_mm = {2000, 0, 0};
  const DesignProblem near{cell, at, at, kDesignNoise};
  cell.base.p_mm = {8000, 0, 0};
  const DesignProblem far{cell, at, at, kDesignNoise};
  EXPECT_GT(near.rows(0).leftCols(3).norm(), far.rows(0).leftCols(3).norm());
}

TEST(PredictedError, IsTheCramerRaoBoundWhereManyPosesOutweighThePrior) {
  const auto measured = poses(60, 9), task = poses(100, 10);
  const CalibratedCell cell = test::planning_cell();
  const double sigma_mm = 0.0001;
  const DesignProblem p{cell, measured, task, {.repeatability_mm = sigma_mm}};
  std::vector<std::size_t> all(measured.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  EXPECT_NEAR(predicted_error(p, all).rms_mm / cramer_rao_rms_mm(cell, measured, task, sigma_mm), 1, 1e-3);
}

TEST(BestAddition, IsTheAllowedCandidateThatAddsMost) {
  const DesignProblem p = problem(50, 11);
  auto chosen = optimal_design(p, {.poses = 12});
  std::vector<bool> allowed(50, true);
  const std::size_t failed = chosen.back();
  chosen.pop_back();
  allowed[failed] = false;
  Design design{p, DesignCriterion::I};
  for (const std::size_t k : chosen) design.add(k);
  const auto addition = best_addition(design, allowed);
  ASSERT_TRUE(addition);
  EXPECT_NE(*addition, failed);
  auto with = chosen;
  with.push_back(*addition);
  const double best = cost(p, DesignCriterion::I, with);
  for (std::size_t k = 0; k < 50; ++k) {
    if (k == failed || std::ranges::find(chosen, k) != chosen.end()) continue;
    with.back() = k;
    EXPECT_GE(cost(p, DesignCriterion::I, with), best * (1 - 1e-9));
  }
  EXPECT_FALSE(best_addition(design, std::vector<bool>(50, false)));
}

TEST(EnoughPoses, AreThoseBeyondWhichTheArmsOwnRepeatabilityRules) {
  // Error 0.1 / sqrt(poses), repeatability 0.01 per axis: 2 x 0.1^2 / (2 n) = 5 % of the sum's square.
  std::vector<DesignSize> sizes;
  for (const int poses : {10, 20, 40, 80, 160, 320})
    sizes.push_back({poses, {.rms_mm = 0.1 / std::sqrt(poses), .max_mm = 0.2}});
  const auto total = [](double poses) { return std::sqrt(0.01 / poses + 3e-4); };
  const auto enough = enough_poses(sizes, 0.01);
  ASSERT_TRUE(enough);
  EXPECT_GE(total(2 * *enough), 0.95 * total(*enough));
  EXPECT_LT(total(*enough), 0.95 * total(0.5 * *enough));
  EXPECT_FALSE(enough_poses(sizes, 1e-6));
}

}  // namespace
}  // namespace truepose
