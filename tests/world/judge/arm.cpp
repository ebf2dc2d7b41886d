#include "tests/world/judge/arm.hpp"

#include <cmath>
#include <cstdint>
#include <map>
#include <string>

namespace truepose::world {

namespace {

Arm::Vector turned(const Arm::Vector& p, int axis, double rad) {
  const auto u = static_cast<std::size_t>((axis + 1) % 3), v = static_cast<std::size_t>((axis + 2) % 3);
  Arm::Vector turned = p;
  turned[u] = std::cos(rad) * p[u] - std::sin(rad) * p[v];
  turned[v] = std::sin(rad) * p[u] + std::cos(rad) * p[v];
  return turned;
}

}  // namespace

Arm::Vector Arm::point(const std::array<double, 6>& q) const {
  Vector p = reflector;
  for (std::size_t i = links.size(); i-- > 0;) {
    const Link& link = links[i];
    p[2] += link.d;
    p = turned(p, 2, link.sign * q[i] + link.theta);
    p[0] += link.a;
    p = turned(p, 0, link.alpha);
    p = turned(p, 1, link.beta);
  }
  for (int axis = 0; axis < 3; ++axis) p = turned(p, axis, base_turn[static_cast<std::size_t>(axis)]);
  for (std::size_t i = 0; i < 3; ++i) p[i] += base[i];
  return p;
}

Arm nominal_arm(const RobotModel& robot) {
  Arm arm;
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    const Joint& joint = robot.joints.at(i);
    arm.links[i] = {joint.a_mm,      joint.alpha_rad, joint.d_mm,
                    joint.theta_rad, joint.beta_rad,  static_cast<double>(joint.sign)};
  }
  return arm;
}

Arm true_arm(const config::Scenario& truth) {
  Arm arm = nominal_arm(truth.truth);
  const Eigen::Matrix3d& R = truth.X_WB.linear();
  arm.base_turn = {std::atan2(R(2, 1), R(2, 2)), std::asin(-R(2, 0)), std::atan2(R(1, 0), R(0, 0))};
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    arm.base[at] = truth.X_WB.translation()[i];
    arm.reflector[at] = truth.p_FS_mm[i];
  }
  return arm;
}

Arm arm_of(const boost::json::array& parameters, const RobotModel& nominal) {
  std::map<std::string, double> values;
  for (const auto& parameter : parameters) {
    const auto& object = parameter.as_object();
    values[std::string{object.at("name").as_string()}] = object.at("value").to_number<double>();
  }
  Arm arm = nominal_arm(nominal);
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    const std::string link = "link" + std::to_string(i + 1) + ".";
    arm.links[i] = {values.at(link + "a"),     values.at(link + "alpha"), values.at(link + "d"),
                    values.at(link + "theta"), values.at(link + "beta"),  arm.links[i].sign};
  }
  constexpr std::array kAxes{"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    arm.base[i] = values.at(std::string{"base."} + kAxes[i]);
    arm.base_turn[i] = values.at(std::string{"base.r"} + kAxes[i]);
    arm.reflector[i] = values.at(std::string{"smr.1."} + kAxes[i]);
  }
  return arm;
}

}  // namespace truepose::world
