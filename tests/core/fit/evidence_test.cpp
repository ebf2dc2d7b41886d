#include "core/fit/evidence.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/calibrate/calibrate.hpp"
#include "core/math/random.hpp"
#include "tests/core/example_arms.hpp"
#include "tests/core/example_campaigns.hpp"

namespace truepose {
namespace {

/// Two classes of unknowns, 40 equations.
EvidenceProblem example_problem(double noise, double first, double second) {
  Random random{3};
  Eigen::MatrixXd J(400, 40);
  for (double& entry : J.reshaped()) entry = random.normal();
  Eigen::VectorXd r(J.rows());
  for (double& entry : r) entry = noise * random.normal();
  EvidenceProblem problem{.equations = 400, .unit = Eigen::VectorXd::Ones(40), .classes = {{1, 3}, {1, 3}}};
  problem.noise = {1, 3};
  for (int i = 0; i < 40; ++i) {
    problem.class_of.push_back(i < 20 ? 0 : 1);
    r -= (i < 20 ? first : second) * random.normal() * J.col(i);
  }
  problem.JtJ = J.transpose() * J;
  problem.Jtr = J.transpose() * r;
  problem.rr = r.squaredNorm();
  return problem;
}

TEST(Evidence, FindsTheNoiseAndHowFarEachClassScatters) {
  const Evidence found = most_evident(example_problem(0.5, 2, 0.1));
  EXPECT_NEAR(found.noise, 0.5, 0.05);
  EXPECT_NEAR(std::log(found.width[0] / 2), 0, 0.5);
  EXPECT_NEAR(std::log(found.width[1] / 0.1), 0, 0.5);
}

TEST(Evidence, HasTheSlopeOfDifferences) {
  const EvidenceProblem problem = example_problem(0.5, 2, 0.1);
  const Eigen::VectorXd at = Eigen::Vector3d(-0.3, 0.4, -1.5);
  Eigen::VectorXd slope, unused;
  negative_log_evidence(problem, at, slope);
  for (int k = 0; k < 3; ++k) {
    const Eigen::VectorXd step = 1e-5 * Eigen::VectorXd::Unit(3, k);
    const double difference =
        negative_log_evidence(problem, at + step, unused) - negative_log_evidence(problem, at - step, unused);
    EXPECT_NEAR(slope[k], difference / 2e-5, 1e-4 * std::abs(slope[k]) + 1e-4);
  }
}

TEST(Prior, MakesTenPosesEnoughForATenthOfAMillimetre) {
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SimulatedCampaign c = example::campaign(example::true_arm(), 10, 30, {.seed = seed});
    sum += example::mean_miss(calibrate(example::kr210(), c.data, {.prior = PriorUse::On}), c);
  }
  EXPECT_LT(sum / 20, 0.10);
}

TEST(Prior, IdentifiesFromFewerPosesThanParametersNeed) {
  const SimulatedCampaign c = example::campaign(example::true_arm(), 8, 30, {.seed = 1});
  const auto result = calibrate(example::kr210(), c.data);
  ASSERT_TRUE(result) << result.error().detail;
  EXPECT_TRUE(result->prior_used);
  EXPECT_LT(result->validate->after.mean, result->validate->before.mean / 2);
}

TEST(Deviations, AreKnownAsWellAsTheirIntervalsSay) {
  int within = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SimulatedCampaign c =
        example::campaign(example::true_arm(heavy_arm_errors({.seed = seed})), 60, 60, {.seed = seed});
    const auto result = calibrate(example::kr210(), c.data, {.non_geometric = true});
    ASSERT_TRUE(result) << result.error().detail;
    for (std::size_t i = 0; i < c.data.points.size(); ++i) {
      const Measurement& m = c.data.points[i];
      if (m.set != PoseSet::Validate) continue;
      const Eigen::Vector3d off = result->cell.predict(m.q, 0, m.direction) - c.p_true_mm[i];
      const Eigen::Matrix3d covariance = result->position_covariance(m.q, 0, m.direction);
      for (int k = 0; k < 3; ++k) within += std::abs(off[k]) <= 1.96 * std::sqrt(covariance(k, k));
      all += 3;
    }
  }
  EXPECT_GE(within, 0.92 * all);
  EXPECT_LE(within, 0.975 * all);
}

}  // namespace
}  // namespace truepose
