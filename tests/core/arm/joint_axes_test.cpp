#include "core/arm/joint_axes.hpp"

#include <gtest/gtest.h>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "core/math/random.hpp"

namespace truepose {
namespace {

using Eigen::Isometry3d, Eigen::Vector3d;

/// The flange by the axes alone: each joint turns about or moves along its line, the outermost first.
Isometry3d flange_by_axes(const std::vector<JointAxis>& axes, const Isometry3d& X_BF, const JointVector& q) {
  Isometry3d X = X_BF;
  for (std::size_t i = axes.size(); i-- > 0;) {
    const double value = q[static_cast<Eigen::Index>(i)];
    const JointAxis& axis = axes[i];
    if (axis.joint.type == JointType::Prismatic) {
      X = Eigen::Translation3d{axis.direction_B * value} * X;
    } else {
      X = Eigen::Translation3d{axis.point_B_mm} * Eigen::AngleAxisd{value, axis.direction_B} *
          Eigen::Translation3d{-axis.point_B_mm} * X;
    }
  }
  return X;
}

Vector3d random_direction(Random& random) {
  return Vector3d{random.normal(), random.normal(), random.normal()}.normalized();
}
Vector3d random_point(Random& random) {
  return {random.uniform(-1000, 1000), random.uniform(-1000, 1000), random.uniform(-1000, 1000)};
}
Isometry3d random_pose(Random& random) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = rotation_zyx(random.uniform(-3, 3), random.uniform(-1, 1), random.uniform(-3, 3));
  X.translation() = random_point(random);
  return X;
}

/// The largest distance (mm, with 1 rad as 1000 mm) between the rows and the lines over random positions.
double largest_miss(const std::vector<JointAxis>& axes, const Isometry3d& X_BF, Random& random) {
  const ArmOfAxes arm = arm_of_axes(axes, X_BF);
  double largest = 0;
  for (int i = 0; i < 20; ++i) {
    JointVector q(static_cast<Eigen::Index>(axes.size()));
    for (double& each : q) each = random.uniform(-3, 3);
    const Isometry3d expected = flange_by_axes(axes, X_BF, q),
                     X = arm.X_base * forward_kinematics(arm.robot, q);
    largest = std::max({largest, (X.translation() - expected.translation()).norm(),
                        1000 * angle_between(X.linear(), expected.linear())});
  }
  return largest;
}

constexpr double kExact = 2e-9;

TEST(JointAxes, OfAnyPlaceBecomeRowsOfTheSameForwardKinematics) {
  Random random{1};
  for (int arm = 0; arm < 200; ++arm) {
    std::vector<JointAxis> axes;
    for (int i = 0; i < 7; ++i) {
      axes.push_back({{}, random_point(random), random_direction(random)});
      if (random.uniform() < 0.2) axes.back().joint.type = JointType::Prismatic;
    }
    EXPECT_LT(largest_miss(axes, random_pose(random), random), kExact) << arm;
  }
}

TEST(JointAxes, ThatAreParallelNearlyParallelCrossingOrOneLineDoToo) {
  Random random{2};
  for (int arm = 0; arm < 200; ++arm) {
    std::vector<JointAxis> axes{{{}, {0, 0, 0}, {0, 0, 1}}};
    for (int i = 1; i < 6; ++i) {
      JointAxis next = axes.back();
      const double kind = random.uniform();
      if (kind < 0.3) next.point_B_mm += random_point(random);  // parallel
      if (kind < 0.2) next.direction_B = (next.direction_B + 1e-4 * random_direction(random)).normalized();
      if (kind < 0.1) next.direction_B = -next.direction_B;
      if (kind > 0.5) next.direction_B = random_direction(random);  // crossing
      if (kind > 0.8) next.direction_B = (i % 2 != 0 ? Vector3d{0, 1, 0} : Vector3d{1, 0, 0});
      axes.push_back(next);
    }
    EXPECT_LT(largest_miss(axes, random_pose(random), random), kExact) << arm;
  }
}

TEST(JointAxes, ThatAlmostMeetDoTooToTheLastDigits) {
  Random random{3};
  for (int arm = 0; arm < 200; ++arm) {
    std::vector<JointAxis> axes;
    for (int i = 0; i < 6; ++i) {
      const Vector3d nominal = i % 2 != 0 ? Vector3d{0, 1, 0} : Vector3d{0, 0, 1};
      const double off = std::pow(10.0, random.uniform(-7, 0));
      axes.push_back({{},
                      Vector3d{0, 0, 300.0 * i} + off * random_direction(random),
                      (nominal + 1e-3 * off * random_direction(random)).normalized()});
    }
    EXPECT_LT(largest_miss(axes, random_pose(random), random), 2e-9) << arm;
  }
}

TEST(JointAxes, OfAKukaGiveTheRowsOfItsDataSheet) {
  const auto axis = [](Vector3d point, Vector3d direction) { return JointAxis{{}, point, direction}; };
  const std::vector<JointAxis> axes{axis({0, 0, 0}, {0, 0, -1}),     axis({330, 0, 645}, {0, 1, 0}),
                                    axis({1480, 0, 645}, {0, 1, 0}), axis({1480, 0, 760}, {-1, 0, 0}),
                                    axis({2700, 0, 760}, {0, 1, 0}), axis({2700, 0, 760}, {-1, 0, 0})};
  Isometry3d X_BF = Isometry3d::Identity();
  X_BF.translation() = Vector3d{2915, 0, 760};
  X_BF.linear() = rotation_zyx(0, 90 * kRadPerDeg, 0);
  const ArmOfAxes arm = arm_of_axes(axes, X_BF);
  EXPECT_TRUE(arm.X_base.isApprox(Isometry3d::Identity()));
  const double rows[6][5] = {{0, 0, 645, 0, -1},      {330, -90, 0, 0, 1}, {1150, 0, 0, -90, 1},
                             {115, -90, 1220, 0, -1}, {0, 90, 0, 0, 1},    {0, -90, 215, 180, -1}};
  for (std::size_t i = 0; i < 6; ++i) {
    const Joint& joint = arm.robot.joints[i];
    EXPECT_EQ(joint.a_mm, rows[i][0]) << i;
    EXPECT_DOUBLE_EQ(joint.alpha_rad * kDegPerRad, rows[i][1]) << i;
    EXPECT_EQ(joint.d_mm, rows[i][2]) << i;
    EXPECT_DOUBLE_EQ(std::abs(joint.theta_rad * kDegPerRad), std::abs(rows[i][3])) << i;
    EXPECT_EQ(joint.beta_rad, 0) << i;
    EXPECT_EQ(joint.sign, rows[i][4]) << i;
  }
  EXPECT_TRUE(arm.robot.X_flange.isApprox(Isometry3d::Identity(), 1e-12));
}

}  // namespace
}  // namespace truepose
