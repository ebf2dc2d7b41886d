#include "core/simulate/published_arm.hpp"

#include <cassert>

#include "core/math/angles.hpp"

namespace truepose {
namespace {

struct Axis {
  double a_mm, alpha_deg, d_mm, theta_deg, sign, min_deg, max_deg, speed_deg_s;
};

constexpr Axis kAxes[] = {
    {0, 0, 645, 0, -1, -185, 185, 116.8}, {330, -90, 0, 0, 1, -140, -5, 111.4},
    {1150, 0, 0, -90, 1, -120, 168, 112}, {115, -90, 1220, 0, -1, -350, 350, 179},
    {0, 90, 0, 0, 1, -125, 125, 172},     {0, -90, 215, 180, -1, -350, 350, 220},
};

}  // namespace

RobotModel published_arm() {
  RobotModel robot{.name = "KUKA KR 210 R2700-2"};
  for (const Axis& axis : kAxes) {
    robot.joints.push_back({.a_mm = axis.a_mm,
                            .alpha_rad = axis.alpha_deg * kRadPerDeg,
                            .d_mm = axis.d_mm,
                            .theta_rad = axis.theta_deg * kRadPerDeg,
                            .sign = axis.sign,
                            .min = axis.min_deg * kRadPerDeg,
                            .max = axis.max_deg * kRadPerDeg,
                            .speed = axis.speed_deg_s * kRadPerDeg});
  }
  return robot;
}

RobotModel with_published_errors(RobotModel nominal) {
  assert(nominal.joints.size() == kPublishedErrors.size());
  for (std::size_t i = 0; i < kPublishedErrors.size(); ++i) {
    Joint& joint = nominal.joints[i];
    const LinkErrors& errors = kPublishedErrors[i];
    joint.a_mm += errors.a_mm;
    joint.alpha_rad += errors.alpha_rad;
    joint.d_mm += errors.d_mm;
    joint.theta_rad += errors.theta_rad;
    joint.beta_rad += errors.beta_rad;
  }
  return nominal;
}

}  // namespace truepose
