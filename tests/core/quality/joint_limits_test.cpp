#include "core/quality/joint_limits.hpp"

#include <gtest/gtest.h>

#include "core/math/units.hpp"

namespace truepose {
namespace {

/// An axis on a rail.
RobotModel rail_and_axis() {
  RobotModel robot;
  robot.joints.resize(2);
  robot.joints[0] = {.type = JointType::Prismatic, .min = 0, .max = 3000};
  robot.joints[1] = {.min = -20 * kRadPerDeg, .max = 20 * kRadPerDeg};
  return robot;
}

std::vector<Measurement> at(std::initializer_list<std::pair<double, double>> mm_deg) {
  std::vector<Measurement> points;
  for (const auto& [mm, deg] : mm_deg) points.push_back({.q = Eigen::Vector2d(mm, deg * kRadPerDeg)});
  return points;
}

TEST(JointLimits, ThatWereKeptToAreNoFinding) {
  EXPECT_FALSE(measured_beyond_limits(rail_and_axis(), at({{0, -20}, {3000, 20}})));
  EXPECT_FALSE(measured_beyond_limits(rail_and_axis(), at({{-0.05, 20.05}})))
      << "what an encoder reads at a hard stop";
}

TEST(JointLimits, AreNamedWithTheJointAndHowFarItWas) {
  const auto one = measured_beyond_limits(rail_and_axis(), at({{10, -148.21}, {20, 3}, {30, 149.6}}));
  ASSERT_TRUE(one);
  EXPECT_EQ(one->severity, Severity::Advice);
  EXPECT_EQ(
      one->sentence,
      "measured beyond the limits of the robot file: joint 2 from -148.2 to 149.6 deg (limits -20 and 20); the "
      "uncertainty of unmeasured poses holds within these limits alone");
  const auto both = measured_beyond_limits(rail_and_axis(), at({{-5, -20.2}, {20, 3}}));
  ASSERT_TRUE(both);
  EXPECT_TRUE(both->sentence.contains(
      "joint 1 from -5.0 to 20.0 mm (limits 0 and 3000), joint 2 from -20.2 to 3.0 deg (limits -20 and 20);"))
      << both->sentence;
}

}  // namespace
}  // namespace truepose
