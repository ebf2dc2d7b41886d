#include "tests/core/on_every_isa.hpp"

#include "core/math/angles.hpp"

namespace truepose::example {

RobotModel random_arm(const std::string& types, Random& random) {
  RobotModel robot;
  for (const char type : types) {
    const bool revolute = type == 'R';
    robot.joints.push_back({.type = revolute ? JointType::Revolute : JointType::Prismatic,
                            .a_mm = random.uniform(-500, 500),
                            .alpha_rad = random.uniform(-2, 2),
                            .d_mm = random.uniform(-500, 500),
                            .theta_rad = random.uniform(-3, 3),
                            .beta_rad = random.uniform(-0.2, 0.2),
                            .sign = random.uniform() < 0.5 ? -1. : 1.,
                            .min = revolute ? -2.5 : -800,
                            .max = revolute ? 2.5 : 800});
  }
  robot.X_flange = pose_from_kuka({random.uniform(-100, 100), random.uniform(-100, 100), 80}, {30, -50, 110});
  return robot;
}

RobotModel kr210(bool calibrated) {
  const double rows[6][11] = {{0, 0, 645, 0, -1, 0.45, 0.003, 0.72, 0.0015, 0, 185},
                              {330, -90, 0, 0, 1, 0.63, 0.002, 0.43, 0.0032, 0, 70},
                              {1150, 0, 0, -90, 1, 0.55, 0.003, 0.21, 0.0026, 0.001, 120},
                              {115, -90, 1220, 0, -1, 0.32, 0.006, 0.32, 0.0018, 0, 350},
                              {0, 90, 0, 0, 1, 0.72, 0.004, 0.51, 0.0012, 0, 125},
                              {0, -90, 215, 180, -1, 0.23, 0.005, 0.62, 0.0022, 0, 350}};
  RobotModel robot;
  for (const auto& row : rows) {
    const double on = calibrated ? 1 : 0;
    robot.joints.push_back({.a_mm = row[0] + on * row[5],
                            .alpha_rad = row[1] * kRadPerDeg + on * row[6],
                            .d_mm = row[2] + on * row[7],
                            .theta_rad = row[3] * kRadPerDeg + on * row[8],
                            .beta_rad = on * row[9],
                            .sign = row[4],
                            .min = -row[10] * kRadPerDeg,
                            .max = row[10] * kRadPerDeg});
  }
  robot.joints[1].min = -140 * kRadPerDeg;
  robot.joints[1].max = -5 * kRadPerDeg;
  return robot;
}

}  // namespace truepose::example
