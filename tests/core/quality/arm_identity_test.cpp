#include "core/quality/arm_identity.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/simulate/published_arm.hpp"

namespace truepose {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct ArmIdentity : testing::Test {
  RobotModel controllers = published_arm(), ours = controllers;
  std::vector<ControllerPose> poses;

  void stands_at(std::initializer_list<double> q_deg) {
    JointVector q(6);
    std::ranges::copy(q_deg, q.begin());
    q *= kRadPerDeg;
    poses.push_back({q, forward_kinematics(controllers, q)});
  }
  std::vector<std::string> mistakes() const {
    std::vector<std::string> found;
    for (const JointMistake& mistake : joint_mistakes(ours, poses, 0.01)) found.push_back(mistake.what);
    return found;
  }
};

TEST_F(ArmIdentity, OfTheSameArmIsNoDistance) {
  stands_at({10, -80, 70, 20, 40, 30});
  EXPECT_LT(largest_deviation_mm(ours, poses), 1e-9);
}

TEST_F(ArmIdentity, ASignShowsOnceItsJointHasMoved) {
  ours.joints[3].sign *= -1;
  stands_at({10, -80, 70, 0, 40, 30});
  EXPECT_LT(largest_deviation_mm(ours, poses), 1e-9);
  stands_at({10, -80, 70, 1, 40, 30});
  EXPECT_GT(largest_deviation_mm(ours, poses), 1);
  EXPECT_THAT(mistakes(), ElementsAre("joint 4 turns the other way"));
}

TEST_F(ArmIdentity, AZeroIsReportedWithItsOffset) {
  ours.joints[1].theta_rad -= 12.5 * kRadPerDeg;
  stands_at({10, -80, 70, 20, 40, 30});
  EXPECT_THAT(mistakes(), ElementsAre("joint 2 has its zero 12.50 deg off"));
}

TEST_F(ArmIdentity, JointsWhoseAxesAreInLineAreBothNamedUntilTheyAreNot) {
  ours.joints[3].theta_rad -= 90 * kRadPerDeg;
  stands_at({10, -80, 70, 0, 0, 0});
  EXPECT_EQ(mistakes().size(), 2U);
  stands_at({10, -80, 70, 0, 1, 0});
  EXPECT_THAT(mistakes(), ElementsAre("joint 4 has its zero 90.00 deg off"));
}

TEST_F(ArmIdentity, AJointThatSlidesIsReportedInMillimetres) {
  controllers.joints[0].type = ours.joints[0].type = JointType::Prismatic;
  ours.joints[0].d_mm -= 4;
  stands_at({0, -80, 70, 20, 40, 30});
  EXPECT_THAT(mistakes(), ElementsAre("joint 1 has its zero 4.00 mm off"));
}

TEST_F(ArmIdentity, WhatNoSignAndNoZeroExplainsIsBlamedOnNoJoint) {
  ours.joints[3].a_mm += 30;
  stands_at({10, -80, 70, 20, 40, 30});
  stands_at({-30, -60, 90, 50, -40, 70});
  EXPECT_GT(largest_deviation_mm(ours, poses), 10);
  EXPECT_THAT(mistakes(), IsEmpty());
}

TEST_F(ArmIdentity, WhatIsNoNumberIsNoAgreement) {
  stands_at({10, -80, 70, 20, 40, 30});
  poses[0].X_BF.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(largest_deviation_mm(ours, poses) <= 1e9);
  EXPECT_THAT(mistakes(), IsEmpty());
}

}  // namespace
}  // namespace truepose
