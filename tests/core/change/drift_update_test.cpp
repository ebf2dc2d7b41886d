#include "core/change/drift_update.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/angles.hpp"
#include "core/simulate/published_arm.hpp"

namespace truepose {
namespace {

/// A cell whose model is exact, and six points spread over its joints.
class UpdateOfAnExactModel : public testing::Test {
 protected:
  UpdateOfAnExactModel() {
    reference_.cell = {.robot = published_arm(),
                       .base = {.p_mm = {4000, 500, -300}, .rxyz_rad = {0, 0, 2.1}},
                       .reflectors = {{"left", {80, 40, 120}}}};
    reference_.noise.repeatability_mm = 0.02;
    reference_.validation_mean_mm = 0.032;
    truth_ = reference_.cell;
    for (const auto& deg : {std::array{-60.0, -60.0, 60.0, 40.0, 50.0, -120.0},
                            {-20.0, -110.0, 120.0, -80.0, -40.0, 60.0},
                            {15.0, -45.0, 30.0, 120.0, 70.0, 170.0},
                            {45.0, -90.0, 100.0, -20.0, -90.0, -30.0},
                            {80.0, -75.0, 70.0, -150.0, 30.0, 100.0},
                            {-100.0, -80.0, 20.0, 70.0, -60.0, 10.0}}) {
      joints_.emplace_back(Eigen::Map<const Eigen::Matrix<double, 6, 1>>(deg.data()) * kRadPerDeg);
    }
  }

  std::vector<Measurement> points() const {
    std::vector<Measurement> points;
    for (const JointVector& q : joints_)
      points.push_back({.q = q, .p_WS_mm = truth_.predict(q, 0), .row = static_cast<int>(points.size()) + 1});
    return points;
  }

  DriftUpdate updated(const std::vector<Measurement>& points) const {
    const auto update = update_after_drift(reference_, points);
    EXPECT_TRUE(update) << (update ? "" : update.error());
    return update ? *update : DriftUpdate{};
  }

  /// Largest distance (mm) between what a cell and the truth predict at poses that were not measured.
  double largest_miss(const CalibratedCell& cell) const {
    double miss = 0;
    for (double turn = -2; turn <= 2; turn += 0.5) {
      const JointVector q = joints_[0] + turn * JointVector::Constant(6, 0.3);
      miss = std::max(miss, (cell.predict(q, 0) - truth_.predict(q, 0)).norm());
    }
    return miss;
  }

  void move_base(const Eigen::Vector3d& mm, double deg) {
    Eigen::Isometry3d X_WB = truth_.base.isometry();
    X_WB.translation() += mm;
    X_WB.linear() = Eigen::AngleAxisd(deg * kRadPerDeg, Eigen::Vector3d::UnitX()) * X_WB.linear();
    truth_.base = BasePose::of(X_WB);
  }

  DriftReference reference_;
  CalibratedCell truth_;
  std::vector<JointVector> joints_;
};

TEST_F(UpdateOfAnExactModel, BringsBackABaseThatMovedAndNothingElse) {
  move_base({0.12, -0.16, 0.15}, 0.01);
  const DriftUpdate update = updated(points());
  EXPECT_TRUE(update.doubts.empty()) << update.doubts.front();
  ASSERT_EQ(update.moves.size(), 1U);
  EXPECT_EQ(update.moves[0].what.kind, ChangeKind::Base);
  EXPECT_LT(largest_miss(update.cell), 0.02);
  EXPECT_EQ(update.cell.reflectors[0].p_FS_mm, reference_.cell.reflectors[0].p_FS_mm);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(update.cell.robot.joints[i].theta_rad, reference_.cell.robot.joints[i].theta_rad);
  EXPECT_GT(update.before_mm, 0.2);
  EXPECT_LT(update.left_out_mm, 0.02);
  const std::string text = described_with_sigma(update.moves[0], update.cell, points());
  EXPECT_TRUE(text.starts_with("the tracker or the base moved by 0.2")) << text;
  EXPECT_NE(text.find(" deg (sigma 0.0"), std::string::npos) << text;
}

TEST_F(UpdateOfAnExactModel, BringsBackAJointsZeroInItsOwnSense) {
  truth_.robot.joints[3].theta_rad += 0.05 * kRadPerDeg;  // joint 4 turns the other way
  const DriftUpdate update = updated(points());
  EXPECT_TRUE(update.doubts.empty()) << update.doubts.front();
  ASSERT_EQ(update.moves.size(), 1U);
  EXPECT_EQ(update.moves[0].what.kind, ChangeKind::JointZero);
  EXPECT_EQ(update.moves[0].what.index, 3);
  EXPECT_NEAR(update.moves[0].moved[0] * kDegPerRad, -0.05, 0.002);
  EXPECT_LT(largest_miss(update.cell), 0.02);
}

TEST_F(UpdateOfAnExactModel, BringsBackBaseZeroAndReflectorAtOnce) {
  move_base({0.3, 0.1, -0.2}, 0.008);
  truth_.robot.joints[2].theta_rad += 0.02 * kRadPerDeg;
  truth_.reflectors[0].p_FS_mm += Eigen::Vector3d(0.2, -0.1, 0.1);
  const DriftUpdate update = updated(points());
  EXPECT_TRUE(update.doubts.empty()) << update.doubts.front();
  EXPECT_EQ(update.moves.size(), 3U);
  EXPECT_LT(largest_miss(update.cell), 0.05);
}

TEST_F(UpdateOfAnExactModel, TakesNoZeroOfAnArmThatWarmedUpAsKnownToBeStill) {
  constexpr std::array kTurned_deg{0.006, -0.008, 0.007, 0.009, -0.0005, 0.001};
  for (std::size_t i = 0; i < 6; ++i) truth_.robot.joints[i].theta_rad += kTurned_deg[i] * kRadPerDeg;
  const DriftUpdate update = updated(points());
  EXPECT_TRUE(update.doubts.empty()) << update.doubts.front();
  ASSERT_EQ(update.moves.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const ChangeFound& move = update.moves[i];
    EXPECT_EQ(move.what, (Change{ChangeKind::JointZero, static_cast<int>(i)}));
    const double turned_rad = moved_between(reference_.cell, truth_, move.what)[0];
    EXPECT_NEAR(move.moved[0], turned_rad, 3 * move.sigma[0]) << i;
    EXPECT_GT(move.sigma[0], 1e-4 * kRadPerDeg) << i;
  }
  EXPECT_LT(largest_miss(update.cell), 0.02);
}

TEST_F(UpdateOfAnExactModel, IsLessSureOfZerosThatSeemStillTheMoreOthersMoved) {
  const auto sigma_rad = [&](double second_deg) {
    truth_.robot = reference_.cell.robot;
    truth_.robot.joints[1].theta_rad += 0.012 * kRadPerDeg;
    truth_.robot.joints[2].theta_rad += second_deg * kRadPerDeg;
    const DriftUpdate update = updated(points());
    EXPECT_EQ(update.moves.size(), second_deg == 0 ? 1U : 2U);
    const int zero = zero_parameter(update.cell.robot, ParameterLayout::of(update.cell), 4);
    return std::sqrt(update.covariance(zero, zero));
  };
  const double one_rad = sigma_rad(0), two_rad = sigma_rad(-0.012);
  EXPECT_GT(one_rad, 0);
  EXPECT_GT(two_rad, 2 * one_rad);
}

TEST_F(UpdateOfAnExactModel, FindsATrackerThatWasSetUpElsewhere) {
  truth_.base = BasePose::of(pose_from_kuka({-3000, 2500, 400}, {150, 2, -3}) * truth_.base.isometry());
  const DriftUpdate update = updated(points());
  EXPECT_TRUE(update.doubts.empty()) << update.doubts.front();
  EXPECT_LT(largest_miss(update.cell), 0.02);
}

TEST_F(UpdateOfAnExactModel, DoesNotFitASingleWrongReading) {
  for (const double off_mm : {0.3, 5.0, 400.0}) {
    std::vector<Measurement> wrong = points();
    wrong[3].p_WS_mm.y() += off_mm;
    const DriftUpdate update = updated(wrong);
    EXPECT_TRUE(update.moves.empty()) << off_mm;
    ASSERT_EQ(update.wrong.size(), 1U) << off_mm;
    EXPECT_EQ(update.wrong[0].what.index, 3);
    EXPECT_EQ(update.doubts, std::vector<std::string>{"nothing has moved that the points could show"});
    EXPECT_LT(largest_miss(update.cell), 1e-9);
  }
}

TEST_F(UpdateOfAnExactModel, LeavesAWrongReadingOutOfAMovedBase) {
  move_base({0.12, -0.16, 0.15}, 0.01);
  std::vector<Measurement> wrong = points();
  wrong[1].p_WS_mm.z() -= 3;
  const DriftUpdate update = updated(wrong);
  EXPECT_TRUE(update.doubts.empty()) << update.doubts.front();
  ASSERT_EQ(update.wrong.size(), 1U);
  EXPECT_EQ(update.wrong[0].what.index, 1);
  EXPECT_LT(largest_miss(update.cell), 0.03);
}

TEST_F(UpdateOfAnExactModel, DoubtsWhatNoMoveOfBaseReflectorAndZerosExplains) {
  for (Joint& joint : truth_.robot.joints) {
    joint.a_mm += 0.3;
    joint.alpha_rad -= 4e-4;
    joint.beta_rad += 3e-4;
  }
  EXPECT_FALSE(updated(points()).doubts.empty());
}

TEST_F(UpdateOfAnExactModel, DoesNotTakeALinkOfAnotherLengthForAWarmerArm) {
  joints_.push_back(0.5 * (joints_[0] + joints_[2]));
  joints_.push_back(0.5 * (joints_[1] + joints_[4]));
  truth_.robot.joints[2].a_mm += 0.3;
  const DriftUpdate update = updated(points());
  EXPECT_FALSE(update.explains);
  EXPECT_TRUE(std::ranges::any_of(
      update.doubts, [](const std::string& doubt) { return doubt.starts_with("link3.a, changed alone,"); }));
}

TEST_F(UpdateOfAnExactModel, TakesAWarmerArmForOne) {
  joints_.push_back(0.5 * (joints_[0] + joints_[2]));
  joints_.push_back(0.5 * (joints_[1] + joints_[4]));
  for (Joint& joint : truth_.robot.joints) {
    joint.a_mm *= 1.0001;
    joint.d_mm *= 1.0001;
  }
  const DriftUpdate update = updated(points());
  EXPECT_TRUE(update.explains);
  EXPECT_TRUE(update.doubts.empty()) << update.doubts.front();
}

TEST_F(UpdateOfAnExactModel, MovesNothingOfAnUnchangedCell) {
  const DriftUpdate update = updated(points());
  EXPECT_TRUE(update.moves.empty());
  EXPECT_FALSE(update.doubts.empty());
  EXPECT_LT(largest_miss(update.cell), 1e-9);
}

TEST_F(UpdateOfAnExactModel, OfOnePointIsDoubted) {
  move_base({0.5, 0, 0}, 0);
  joints_.resize(1);
  EXPECT_FALSE(updated(points()).doubts.empty());
}

TEST_F(UpdateOfAnExactModel, KnowsWhatMovedLessWellThanBeforeAndTheRestAsWell) {
  const int size = ParameterLayout::of(truth_).size();
  reference_.covariance = Eigen::MatrixXd::Zero(size, size);
  reference_.covariance.diagonal().setConstant(1e-12);
  move_base({0.12, -0.16, 0.15}, 0.01);
  const DriftUpdate update = updated(points());
  EXPECT_LT((update.covariance - update.covariance.transpose()).norm(), 1e-15);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(std::sqrt(update.covariance(k, k)), update.moves[0].sigma[k], 1e-4);
  for (int k = 6; k < size; ++k) EXPECT_NEAR(update.covariance(k, k), 1e-12, 1e-15);
}

}  // namespace
}  // namespace truepose
