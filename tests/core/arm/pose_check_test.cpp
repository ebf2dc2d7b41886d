#include "core/arm/pose_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numbers>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"

namespace truepose {
namespace {

using Place = PoseExplanation::Place;

RobotModel six_axes() {
  const double kRight = std::numbers::pi / 2;
  RobotModel robot;
  robot.joints = {{.d_mm = 645, .sign = -1},
                  {.a_mm = 330, .alpha_rad = -kRight},
                  {.a_mm = 1150, .theta_rad = -kRight},
                  {.a_mm = 115, .alpha_rad = -kRight, .d_mm = 1220, .sign = -1},
                  {.alpha_rad = kRight},
                  {.alpha_rad = -kRight, .d_mm = 215, .theta_rad = 2 * kRight, .sign = -1}};
  return robot;
}

/// What the pendant of an arm shows at some positions.
std::vector<PoseReading> shown_by(const RobotModel& robot) {
  Random random{4};
  std::vector<PoseReading> readings;
  for (int i = 0; i < 6; ++i) {
    JointVector q(6);
    for (double& each : q) each = random.uniform(-1.5, 1.5);
    readings.push_back({q, forward_kinematics(robot, q)});
  }
  return readings;
}

TEST(PoseCheck, FindsNothingToExplainWhereTheFileFits) {
  const auto readings = shown_by(six_axes());
  for (const PoseDifference& each : differences_of(six_axes(), readings)) {
    EXPECT_LT(each.mm, 1e-9);
    EXPECT_LT(each.rad, 1e-9);
  }
}

TEST(PoseCheck, NamesTheRowWhoseLengthAngleOrSignIsWrong) {
  const auto explained = [](const std::function<void(Joint&)>& mistake, int joint) {
    RobotModel wrong = six_axes();
    mistake(wrong.joints[static_cast<std::size_t>(joint)]);
    const auto causes = explain_differences(wrong, shown_by(six_axes()));
    ASSERT_FALSE(causes.empty()) << joint;
    EXPECT_LT(causes.front().rms_mm, 1e-3) << joint;
    const bool names_it = std::ranges::any_of(
        causes, [&](const PoseExplanation& e) { return e.place == Place::Row && e.joint == joint; });
    EXPECT_TRUE(names_it) << joint;
    EXPECT_TRUE(differences_of(causes.front().fixed, shown_by(six_axes())).front().mm < 1e-3 ||
                causes.front().place == Place::Base)
        << joint;
  };
  explained([](Joint& row) { row.d_mm += 20; }, 3);
  explained([](Joint& row) { row.a_mm -= 15; }, 2);
  explained([](Joint& row) { row.theta_rad += std::numbers::pi / 2; }, 2);
  explained([](Joint& row) { row.theta_rad += 0.01; }, 4);
  explained([](Joint& row) { row.alpha_rad += 0.02; }, 4);
  for (int joint = 0; joint < 6; ++joint) explained([](Joint& row) { row.sign = -row.sign; }, joint);
}

TEST(PoseCheck, NamesAMissingCouplingATurnedFlangeAndAShiftedBase) {
  RobotModel coupled = six_axes();
  coupled.coupling = {{.joint = 2, .to = 1, .factor = 1}};
  const auto coupling = explain_differences(six_axes(), shown_by(coupled));
  ASSERT_FALSE(coupling.empty());
  EXPECT_EQ(coupling.front().place, Place::Coupling);
  EXPECT_EQ(coupling.front().fixed.coupling, coupled.coupling);

  RobotModel flanged = six_axes();
  flanged.X_flange = pose_from_kuka({10, 20, 30}, {5, -3, 2});
  const auto flange = explain_differences(six_axes(), shown_by(flanged));
  ASSERT_FALSE(flange.empty());
  EXPECT_EQ(flange.front().place, Place::Flange);
  EXPECT_TRUE(flange.front().fixed.X_flange.isApprox(flanged.X_flange, 1e-6));

  std::vector<PoseReading> shifted = shown_by(six_axes());
  const Eigen::Isometry3d X_base = pose_from_kuka({100, -50, 0}, {0, 3, 0});
  for (PoseReading& each : shifted) each.X_BF = X_base * each.X_BF;
  const auto base = explain_differences(six_axes(), shifted);
  ASSERT_FALSE(base.empty());
  EXPECT_EQ(base.front().place, Place::Base);
  EXPECT_TRUE(base.front().X_base.isApprox(X_base, 1e-6));
}

}  // namespace
}  // namespace truepose
