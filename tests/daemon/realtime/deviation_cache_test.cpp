#include "daemon/realtime/deviation_cache.hpp"

#include <gtest/gtest.h>

#include "tests/daemon/heavy_model.hpp"

namespace truepose::daemon {
namespace {

constexpr double kWire_rad = 1e-6 * kRadPerDeg;  // the last digit of a reply

/// An arm on its way, and how far its compensation is from what it would be without foresight.
class DeviationCacheTest : public testing::Test {
 protected:
  double step(const JointVector& move) {
    q_ += move;
    const JointVector exact = without(compensation_), q = with(compensation_);
    deviation_cache_.look_ahead(compensation_);
    return (q - exact).cwiseAbs().maxCoeff();
  }
  JointVector without(const TargetCompensation& compensation) const {
    JointVector search = JointVector::Zero(6);
    return compensation.at_joints_within(kSteps, q_, p_F_mm_, search)->q;
  }
  JointVector with(const TargetCompensation& compensation) {
    JointVector search = JointVector::Zero(6);
    return deviation_cache_.at_joints_within(kSteps, compensation, q_, p_F_mm_, search)->q;
  }

  static constexpr int kSteps = 50;

  const TargetCompensation compensation_{nominal_arm(), heavy_arm()};
  const Eigen::Vector3d p_F_mm_{60, -50, 190};
  DeviationCache deviation_cache_;
  JointVector q_ = axes_deg({10, -80, 90, 20, 45, -30});
};

TEST_F(DeviationCacheTest, CompensatesAnArmThatStandsOrMovesEvenlyAsWithoutIt) {
  EXPECT_EQ(step(axes_deg({0, 0, 0, 0, 0, 0})), 0);
  for (int i = 0; i < 10; ++i) EXPECT_LT(step(axes_deg({0, 0, 0, 0, 0, 0})), 0.01 * kWire_rad);
  step(axes_deg({0.4, 0.2, -0.3, 0.4, 0.1, -0.4}));
  for (int i = 0; i < 100; ++i) EXPECT_LT(step(axes_deg({0.4, 0.2, -0.3, 0.4, 0.1, -0.4})), 0.1 * kWire_rad);
}

TEST_F(DeviationCacheTest, KeepsToTheWiresLastDigitWhereTheArmSpeedsUp) {
  JointVector move = JointVector::Zero(6);
  for (int i = 0; i < 100; ++i) {
    move += axes_deg({0.0045, -0.004, 0.0045, 0.0045, -0.004, 0.0045});
    EXPECT_LT(step(move), 3 * kWire_rad) << i;
  }
}

TEST_F(DeviationCacheTest, ComputesAgainWhereTheArmIsNotWhereItWasExpected) {
  for (int i = 0; i < 10; ++i) {
    step(axes_deg({0.4, 0.2, -0.3, 0.4, 0.1, -0.4}));
    EXPECT_EQ(step(axes_deg({-2, 1, 2, -3, 1, 2})), 0) << "as exact as without it";
  }
}

TEST_F(DeviationCacheTest, GoesThroughTheWristSingularityAsWithoutIt) {
  q_[4] = 10 * kRadPerDeg;
  bool damped = false;
  for (int i = 0; i < 200; ++i) {
    EXPECT_LT(step(axes_deg({0, 0, 0, 0, -0.1, 0})), kWire_rad) << i;
    damped = damped || compensation_.at_joints(q_, p_F_mm_)->damped;
  }
  EXPECT_TRUE(damped);
}

TEST_F(DeviationCacheTest, HasNoMemoryOfAnotherModel) {
  for (int i = 0; i < 3; ++i) step(axes_deg({0.1, 0, 0, 0, 0, 0}));
  const TargetCompensation other{nominal_arm(), heavy_arm(10)};
  deviation_cache_.restart();
  EXPECT_EQ(with(other), without(other));
}

}  // namespace
}  // namespace truepose::daemon
