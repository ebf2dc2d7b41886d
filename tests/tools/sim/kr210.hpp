#pragma once

#include <cstddef>
#include <numbers>

#include "core/arm/robot_model.hpp"
#include "core/math/angles.hpp"

namespace truepose::sim {

/// The data sheet of a KR 210 R2700-2: mm, rad.
inline RobotModel kr210() {
  const double quarter = std::numbers::pi / 2;
  RobotModel robot;
  robot.name = "KR 210";
  robot.joints = {{.d_mm = 645, .sign = -1},
                  {.a_mm = 330, .alpha_rad = -quarter},
                  {.a_mm = 1150, .theta_rad = -quarter},
                  {.a_mm = 115, .alpha_rad = -quarter, .d_mm = 1220, .sign = -1},
                  {.alpha_rad = quarter},
                  {.alpha_rad = -quarter, .d_mm = 215, .sign = -1}};
  const double limits_deg[6][2] = {{-185, 185}, {-140, -5},  {-120, 168},
                                   {-350, 350}, {-125, 125}, {-350, 350}};
  const double speeds_deg[6] = {117, 111, 112, 179, 172, 220};
  for (std::size_t i = 0; i < 6; ++i) {
    robot.joints[i].min = limits_deg[i][0] * kRadPerDeg;
    robot.joints[i].max = limits_deg[i][1] * kRadPerDeg;
    robot.joints[i].speed = speeds_deg[i] * kRadPerDeg;
  }
  return robot;
}

inline JointVector deg(double a1, double a2, double a3, double a4, double a5, double a6) {
  return JointVector{{a1, a2, a3, a4, a5, a6}} * kRadPerDeg;
}

}  // namespace truepose::sim
