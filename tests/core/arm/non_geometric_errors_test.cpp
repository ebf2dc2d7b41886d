#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/arm/forward.hpp"
#include "core/simulate/true_arm.hpp"
#include "tests/core/two_joints.hpp"

namespace truepose {
namespace {

/// Two joints about horizontal axes, q = 0 stretched along x, the second one turning the other way: links of
/// 1 m, each with its mass at its end.
RobotModel heavy_pendulum() {
  RobotModel robot;
  robot.joints = {{.alpha_rad = -std::numbers::pi / 2}, {.a_mm = 1000, .sign = -1}};
  return robot;
}

NonGeometricErrors masses(double first_kg, double second_kg) {
  NonGeometricErrors errors;
  errors.masses = {{first_kg, {1000, 0, 0}}, {second_kg, {1000, 0, 0}}};
  errors.drives.resize(2);
  return errors;
}

/// Potential energy (N m), from the heights of the masses alone.
double potential_energy(const RobotModel& arm, const NonGeometricErrors& errors, const JointVector& q) {
  Eigen::Isometry3d X_B = Eigen::Isometry3d::Identity();
  double energy = 0;
  for (std::size_t i = 0; i < errors.masses.size(); ++i) {
    const LinkMass& link = errors.masses[i];
    X_B = X_B * link_transform(arm.joints[i], q[static_cast<Eigen::Index>(i)]);
    energy -= link.mass_kg * errors.gravity_B_mps2.dot(X_B * link.centre_mm) * 1e-3;
  }
  return energy;
}

TEST(GravityTorque, PullsAStretchedPendulumDownInEachJointsOwnSense) {
  const JointVector torque = gravity_torque_Nm(heavy_pendulum(), masses(3, 2), two_joints(0, 0));
  // 3 kg at 1 m and 2 kg at 2 m; the first axis points to +y, so down is its positive turn.
  EXPECT_NEAR(torque[0], 9.80665 * 7, 1e-9);
  EXPECT_NEAR(torque[1], -9.80665 * 2, 1e-9);
  EXPECT_LT(forward_kinematics(heavy_pendulum(), two_joints(0.1, 0)).translation().z(), 0);
}

TEST(GravityTorque, IsTheSlopeOfThePotentialEnergyForAnyGravity) {
  NonGeometricErrors errors = masses(30, 20);
  errors.masses[0].centre_mm = {400, -50, 30};
  errors.gravity_B_mps2 = {3, -2, -8};
  for (const JointVector& q : {two_joints(0.3, -0.8), two_joints(-2, 1.1), two_joints(1.5, 3)}) {
    const JointVector torque = gravity_torque_Nm(heavy_pendulum(), errors, q);
    for (int i = 0; i < 2; ++i) {
      JointVector step = JointVector::Zero(2);
      step[i] = 1e-5;
      const double slope = (potential_energy(heavy_pendulum(), errors, q + step) -
                            potential_energy(heavy_pendulum(), errors, q - step)) /
                           2e-5;
      EXPECT_NEAR(torque[i], -slope, 1e-6);
    }
  }
}

TEST(JointDisplacement, IsNothingForARigidArmWithPerfectGears) {
  EXPECT_EQ(joint_displacement(heavy_pendulum(), {}, two_joints(1, 2), {}), two_joints(0, 0));
  EXPECT_EQ(joint_displacement(heavy_pendulum(), masses(30, 20), two_joints(1, 2), {1, -1}),
            two_joints(0, 0));
}

TEST(JointDisplacement, IsInEquilibriumWithTheTorqueOfTheDeflectedArm) {
  NonGeometricErrors errors = masses(300, 200);
  errors.drives[0] = {.compliance_rad_per_Nm = 1e-6, .harmonics = {{{2e-4, 0.3}, {1e-4, 1.0}}}};
  errors.drives[1] = {.compliance_rad_per_Nm = 3e-6};
  const JointVector q = two_joints(0.4, -1.2);
  const JointVector displacement = joint_displacement(heavy_pendulum(), errors, q, {});
  const JointVector torque = gravity_torque_Nm(heavy_pendulum(), errors, q + displacement);
  EXPECT_NEAR(displacement[0], 1e-6 * torque[0] + 2e-4 * std::sin(0.7) + 1e-4 * std::sin(1.8), 1e-12);
  EXPECT_NEAR(displacement[1], 3e-6 * torque[1], 1e-12);
}

TEST(JointDisplacement, LeavesAJointHalfThePlayBehindItsMotion) {
  NonGeometricErrors errors = masses(0, 0);
  errors.drives[0].backlash_rad = errors.drives[1].backlash_rad = 4e-5;
  EXPECT_EQ(joint_displacement(heavy_pendulum(), errors, two_joints(1, 2), {1, -1}), two_joints(-2e-5, 2e-5));
  EXPECT_EQ(joint_displacement(heavy_pendulum(), errors, two_joints(1, 2), {0, 0}), two_joints(0, 0));
  EXPECT_EQ(joint_displacement(heavy_pendulum(), errors, two_joints(1, 2), {}), two_joints(0, 0));
}

TEST(HeavyArmErrors, KeepTheirGearsWhenTheOtherErrorsAreTurnedOff) {
  const NonGeometricErrors all = heavy_arm_errors({.backlash_rad = 3e-5, .seed = 7});
  const NonGeometricErrors gears = heavy_arm_errors({.compliance = false, .seed = 7});
  const NonGeometricErrors others = heavy_arm_errors({.compliance = false, .seed = 8});
  double moving_kg = 0;
  for (const LinkMass& link : all.masses) moving_kg += link.mass_kg;
  EXPECT_GT(moving_kg, 900);
  EXPECT_LT(moving_kg, 1100);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(gears.drives[i].harmonics[0].phase_rad, all.drives[i].harmonics[0].phase_rad);
    EXPECT_NE(gears.drives[i].harmonics[0].phase_rad, others.drives[i].harmonics[0].phase_rad);
    EXPECT_EQ(gears.drives[i].compliance_rad_per_Nm, 0);
    EXPECT_GT(all.drives[i].compliance_rad_per_Nm, 0);
    EXPECT_EQ(all.drives[i].backlash_rad, 3e-5);
  }
}

}  // namespace
}  // namespace truepose
