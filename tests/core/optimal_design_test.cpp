#include "core/planning/optimal_design.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "config/robot_file.hpp"
#include "core/calibration/calibrate.hpp"
#include "core/evaluation/cramer_rao.hpp"
#include "core/random.hpp"
#include "core/simulation/measurement_campaign.hpp"

namespace truepose {
namespace {

CalibratedCell cell() {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  X_WB.translation() = Eigen::Vector3d{4000, 500, -300};
  return {config::load_robot(TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml"),
          BasePose::of(X_WB),
          {{"1", {80, 40, 120}}}};
}

std::vector<JointVector> poses(int count, std::uint64_t seed) {
  Random random{seed};
  return random_poses(cell().robot, count, random);
}

std::vector<JointVector> picked(const std::vector<JointVector>& from, const std::vector<std::size_t>& which) {
  std::vector<JointVector> out;
  for (const std::size_t k : which) out.push_back(from[k]);
  return out;
}

/// log of the determinant of the information, in the basis that all candidates give.
double log_information(const std::vector<JointVector>& candidates, const std::vector<JointVector>& design) {
  const Eigen::MatrixXd A =
      position_jacobian(cell(), design) * whitened_basis(position_jacobian(cell(), candidates));
  return std::log((A.transpose() * A).determinant());
}

TEST(CramerRao, KnowsTwentySevenParametersOfAKr210) {
  EXPECT_EQ(whitened_basis(position_jacobian(cell(), poses(60, 1))).cols(), 27);
}

TEST(CramerRao, AtTheMeasuredPosesIsTheShareOfParametersInTheEquations) {
  // The projection onto 27 of 90 coordinates: trace 27 over 30 points.
  const auto measured = poses(30, 2);
  EXPECT_NEAR(cramer_rao_rms_mm(cell(), measured, measured, 0.02), 0.02 * std::sqrt(27.0 / 30), 1e-9);
}

TEST(CramerRao, IsWhatTheFitReachesOverManyTrials) {
  const auto measured = poses(30, 3), elsewhere = poses(100, 4);
  const CalibratedCell truth = cell();
  const double sigma_mm = 0.0194;
  const TrueArmSetup arm{
      .robot = truth.robot, .X_WB = truth.base.isometry(), .p_FS_mm = truth.reflectors[0].p_FS_mm};
  double squares = 0;
  const int trials = 60;
  for (int trial = 0; trial < trials; ++trial) {
    const SimulatedCampaign campaign =
        measure_campaign(arm, measured, {}, {.tracker_noise_mm = sigma_mm, .seed = std::uint64_t(trial)});
    const auto fit = calibrate(truth.robot, campaign.data);
    ASSERT_TRUE(fit) << fit.error().detail;
    for (const JointVector& q : elsewhere)
      squares += (fit->cell.predict(q, 0) - truth.predict(q, 0)).squaredNorm();
  }
  const double rms_mm = std::sqrt(squares / trials / 100);
  EXPECT_NEAR(rms_mm / cramer_rao_rms_mm(truth, measured, elsewhere, sigma_mm), 1, 0.06);
}

TEST(OptimalDesign, ChoosesDistinctPosesThatPredictBetterThanRandomOnes) {
  const auto candidates = poses(400, 5), task = poses(200, 6), judged = poses(200, 7);
  const auto design = optimal_design(cell(), candidates, task, {.poses = 30});
  ASSERT_EQ(design.size(), 30u);
  EXPECT_EQ(std::ranges::adjacent_find(design), design.end());
  const std::vector<JointVector> random(candidates.begin(), candidates.begin() + 30);
  EXPECT_LT(cramer_rao_rms_mm(cell(), picked(candidates, design), judged, 1),
            0.85 * cramer_rao_rms_mm(cell(), random, judged, 1));
}

TEST(OptimalDesign, ServesTheCriterionThatItWasGiven) {
  const auto candidates = poses(400, 8), task = poses(200, 9);
  const auto d = picked(
      candidates, optimal_design(cell(), candidates, task, {.criterion = DesignCriterion::D, .poses = 30}));
  const auto i = picked(
      candidates, optimal_design(cell(), candidates, task, {.criterion = DesignCriterion::I, .poses = 30}));
  EXPECT_GT(log_information(candidates, d), log_information(candidates, i));
  EXPECT_LT(cramer_rao_rms_mm(cell(), i, task, 1), cramer_rao_rms_mm(cell(), d, task, 1));
}

TEST(OptimalDesign, CannotBeBetteredByExchangingOnePose) {
  const auto candidates = poses(80, 10), task = poses(50, 11);
  const auto chosen = optimal_design(cell(), candidates, task, {.poses = 12});
  const double best = cramer_rao_rms_mm(cell(), picked(candidates, chosen), task, 1);
  for (std::size_t slot = 0; slot < chosen.size(); ++slot) {
    for (std::size_t other = 0; other < candidates.size(); ++other) {
      if (std::ranges::binary_search(chosen, other)) continue;
      auto exchanged = chosen;
      exchanged[slot] = other;
      ASSERT_GE(cramer_rao_rms_mm(cell(), picked(candidates, exchanged), task, 1), best * (1 - 1e-6));
    }
  }
}

}  // namespace
}  // namespace truepose
