#include "tests/world/truth_judge.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>

#include "core/math/random.hpp"

namespace truepose::world {

namespace {

using Vector = std::array<double, 3>;

Vector turned(const Vector& p, int axis, double rad) {
  const auto u = static_cast<std::size_t>((axis + 1) % 3), v = static_cast<std::size_t>((axis + 2) % 3);
  Vector turned = p;
  turned[u] = std::cos(rad) * p[u] - std::sin(rad) * p[v];
  turned[v] = std::sin(rad) * p[u] + std::cos(rad) * p[v];
  return turned;
}

/// Of one link, modified DH with Hayati's beta.
struct Link {
  double a = 0, alpha = 0, d = 0, theta = 0, beta = 0, sign = 1;
};

struct Arm {
  std::array<Link, 6> links;
  Vector base{}, base_turn{};  // position, and turns about x, then y, then z of the tracker
  Vector reflector{};

  Vector point(const std::array<double, 6>& q) const {
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
};

Arm true_arm(const config::Scenario& truth) {
  Arm arm;
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    const Joint& joint = truth.truth.joints.at(i);
    arm.links[i] = {joint.a_mm,      joint.alpha_rad, joint.d_mm,
                    joint.theta_rad, joint.beta_rad,  static_cast<double>(joint.sign)};
  }
  const Eigen::Matrix3d& R = truth.X_WB.linear();
  arm.base_turn = {std::atan2(R(2, 1), R(2, 2)), std::asin(-R(2, 0)), std::atan2(R(1, 0), R(0, 0))};
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    arm.base[at] = truth.X_WB.translation()[i];
    arm.reflector[at] = truth.p_FS_mm[i];
  }
  return arm;
}

Arm arm_of(const boost::json::array& parameters, const config::Scenario& nominal) {
  std::map<std::string, double> values;
  for (const auto& parameter : parameters) {
    const auto& object = parameter.as_object();
    values[std::string{object.at("name").as_string()}] = object.at("value").to_number<double>();
  }
  Arm arm;
  for (std::size_t i = 0; i < arm.links.size(); ++i) {
    const std::string link = "link" + std::to_string(i + 1) + ".";
    arm.links[i] = {values.at(link + "a"),    values.at(link + "alpha"),
                    values.at(link + "d"),    values.at(link + "theta"),
                    values.at(link + "beta"), static_cast<double>(nominal.nominal.joints.at(i).sign)};
  }
  constexpr std::array kAxes{"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    arm.base[i] = values.at(std::string{"base."} + kAxes[i]);
    arm.base_turn[i] = values.at(std::string{"base.r"} + kAxes[i]);
    arm.reflector[i] = values.at(std::string{"smr.1."} + kAxes[i]);
  }
  return arm;
}

}  // namespace

Eigen::Vector3d true_point_mm(const JointVector& q_rad, const config::Scenario& truth) {
  std::array<double, 6> q{};
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = q_rad[static_cast<Eigen::Index>(i)];
  const Vector p_mm = true_arm(truth).point(q);
  return {p_mm[0], p_mm[1], p_mm[2]};
}

double mean_error_mm(const boost::json::array& parameters, const config::Scenario& truth) {
  constexpr std::array<std::array<double, 2>, 6> kRanges_rad{
      {{-1, 1}, {-2, -1}, {1, 2}, {-1.5, 1.5}, {-1, 1}, {-1.5, 1.5}}};
  constexpr int kPoses = 100;
  const Arm real = true_arm(truth), model = arm_of(parameters, truth);
  Random random{1};
  Eigen::Matrix3Xd there(3, kPoses), found(3, kPoses);
  for (int pose = 0; pose < kPoses; ++pose) {
    std::array<double, 6> q{};
    for (std::size_t i = 0; i < q.size(); ++i) q[i] = random.uniform(kRanges_rad[i][0], kRanges_rad[i][1]);
    const Vector a = real.point(q), b = model.point(q);
    there.col(pose) << a[0], a[1], a[2];
    found.col(pose) << b[0], b[1], b[2];
  }
  // Where the tracker stands is not the arm's.
  const Eigen::Isometry3d to_there{Eigen::umeyama(found, there, false)};
  return (to_there * found - there).colwise().norm().mean();
}

}  // namespace truepose::world
