#include "core/arm/spherical_wrist.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/arm/joint_coupling.hpp"
#include "core/math/angles.hpp"

namespace truepose {
namespace {

constexpr double kSame = 1e-9;  // mm, rad: what counts as nominal geometry

bool is_zero(double value) { return std::abs(value) < kSame; }
bool is_right_angle(double alpha_rad) { return std::abs(std::abs(alpha_rad) - std::numbers::pi / 2) < kSame; }

double wrapped(double angle) {
  const double a = std::remainder(angle, 2 * std::numbers::pi);
  return a <= -std::numbers::pi ? a + 2 * std::numbers::pi : a;
}

Eigen::Matrix3d Rx(double a) { return Eigen::AngleAxisd(a, Eigen::Vector3d::UnitX()).toRotationMatrix(); }
Eigen::Matrix3d Rz(double a) { return Eigen::AngleAxisd(a, Eigen::Vector3d::UnitZ()).toRotationMatrix(); }

/// The condition that `robot` does not meet, or nothing.
std::string unmet_condition(const RobotModel& robot) {
  if (robot.joint_count() != 6) return "it has " + std::to_string(robot.joint_count()) + " joints, not 6";
  const auto& j = robot.joints;
  for (const Joint& joint : j) {
    if (joint.type != JointType::Revolute) return "a joint is prismatic";
  }
  for (std::size_t i = 1; i < 6; ++i) {
    if (!is_zero(j[i].beta_rad)) return "joint " + std::to_string(i + 1) + " has a beta";
  }
  for (const std::size_t i : {1UZ, 3UZ, 4UZ, 5UZ}) {
    if (!is_right_angle(j[i].alpha_rad))
      return "alpha of joint " + std::to_string(i + 1) + " is not +-90 deg";
  }
  if (!is_zero(j[2].alpha_rad)) return "axes 2 and 3 are not parallel";
  if (!is_zero(j[4].a_mm) || !is_zero(j[5].a_mm) || !is_zero(j[4].d_mm))
    return "axes 4, 5 and 6 do not meet in a point";
  if (is_zero(j[2].a_mm)) return "axes 2 and 3 coincide";
  for (const JointCoupling& each : robot.coupling) {
    if (each.factor != std::round(each.factor))  // a turn of one joint would be part of a turn of the other
      return "joint " + std::to_string(each.joint + 1) + " is coupled by a factor that is not whole";
  }
  return {};
}

/// The thetas of axes 4 to 6 that turn by A together. Where axes 4 and 6 are in line, axis 4 stays.
///
/// @param flip         sign by which axis 5 bends
/// @param theta4_near  where axis 4 stays
std::array<double, 3> wrist_angles(const std::vector<Joint>& joint, const Eigen::Matrix3d& A, double flip,
                                   double theta4_near) {
  const double s5 = joint[4].alpha_rad > 0 ? 1 : -1;
  const double s6 = joint[5].alpha_rad > 0 ? 1 : -1;
  const double sin5 = std::hypot(A(0, 2), A(1, 2));
  const double theta5 = std::atan2(flip * sin5, -s5 * s6 * A(2, 2));
  const double theta4 = sin5 > kSame ? std::atan2(flip * s6 * A(1, 2), flip * s6 * A(0, 2)) : theta4_near;
  const Eigen::Matrix3d R_46 =
      (Rz(theta4) * Rx(joint[4].alpha_rad) * Rz(theta5) * Rx(joint[5].alpha_rad)).transpose() * A;
  return {theta4, theta5, std::atan2(R_46(1, 0), R_46(0, 0))};
}

/// q + 2 pi k nearest to `near` within the limits of `joint`, or NaN where no turn lies within them.
double turned_into_limits(const Joint& joint, double q, double near) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double wanted = q + kTurn * std::round((near - q) / kTurn);
  double best = std::numeric_limits<double>::quiet_NaN();
  for (double k = -2; k <= 2; ++k) {
    const double candidate = wanted + k * kTurn;
    if (candidate < joint.min - kSame || candidate > joint.max + kSame) continue;
    if (std::isnan(best) || std::abs(candidate - near) < std::abs(best - near)) best = candidate;
  }
  return best;
}

}  // namespace

SphericalWristInverse::SphericalWristInverse(RobotModel robot) : robot_{std::move(robot)} {}

std::expected<SphericalWristInverse, std::string> SphericalWristInverse::of(const RobotModel& robot) {
  if (std::string why = unmet_condition(robot); !why.empty()) {
    return std::unexpected("no closed-form inverse for " + robot.name + ": " + why);
  }
  return SphericalWristInverse{robot};
}

SphericalWristInverse::Solutions SphericalWristInverse::all(const Eigen::Isometry3d& X_BF,
                                                            const JointVector& q_near) const {
  const auto& joint = robot_.joints;
  const JointVector q_near_chain = chain_joints(robot_.coupling, q_near);
  const double s2 = joint[1].alpha_rad > 0 ? 1 : -1;
  const double theta4_near = joint[3].sign * q_near_chain[3] + joint[3].theta_rad;

  // Seen from the foot of axis 1: what stands before its rotation, and the flange after axis 6, are constant.
  Joint foot = joint[0];
  foot.theta_rad = 0;
  foot.d_mm = 0;
  const Eigen::Isometry3d X_06 = inverse_of(link_transform(foot, 0)) * X_BF * inverse_of(robot_.X_flange);
  const Eigen::Vector3d wrist = X_06 * Eigen::Vector3d(0, 0, -joint[5].d_mm);

  const double offset = joint[1].d_mm + joint[2].d_mm;  // of the arm's plane from axis 1
  const double reach = std::hypot(wrist.x(), wrist.y());
  if (reach < std::abs(offset) || reach < kSame) return {};
  const double bearing = std::atan2(wrist.y(), wrist.x());
  const double psi = std::asin(std::clamp(-s2 * offset / reach, -1.0, 1.0));

  const Eigen::Vector2d forearm(joint[3].a_mm, -std::sin(joint[3].alpha_rad) * joint[3].d_mm);
  const double l2 = joint[2].a_mm, l3 = forearm.norm(), gamma = std::atan2(forearm.y(), forearm.x());

  Solutions out;
  for (const double front : {1.0, -1.0}) {
    const double theta1 = front > 0 ? bearing - psi : bearing - std::numbers::pi + psi;
    const double x = front * std::sqrt(std::max(0.0, reach * reach - offset * offset)) - joint[1].a_mm;
    const double y = s2 * (wrist.z() - joint[0].d_mm);
    const double cos_elbow = (x * x + y * y - l2 * l2 - l3 * l3) / (2 * l2 * l3);
    if (std::abs(cos_elbow) > 1) continue;
    for (const double elbow : {std::acos(cos_elbow), -std::acos(cos_elbow)}) {
      const double theta3 = elbow - gamma;
      const double theta2 = std::atan2(y, x) - std::atan2(l3 * std::sin(elbow), l2 + l3 * std::cos(elbow));
      const Eigen::Matrix3d R_03 = Rz(theta1) * Rx(joint[1].alpha_rad) * Rz(theta2 + theta3);
      const Eigen::Matrix3d A = Rx(-joint[3].alpha_rad) * R_03.transpose() * X_06.linear();
      for (const double flip : {1.0, -1.0}) {
        const auto [theta4, theta5, theta6] = wrist_angles(joint, A, flip, theta4_near);
        const std::array theta{theta1, theta2, theta3, theta4, theta5, theta6};
        JointVector& q = out.q[static_cast<std::size_t>(out.count++)];
        q.resize(6);
        for (std::size_t i = 0; i < 6; ++i) {
          q[static_cast<Eigen::Index>(i)] = joint[i].sign * (theta[i] - joint[i].theta_rad);
        }
        q = controller_joints(robot_.coupling, q).unaryExpr(&wrapped);
      }
    }
  }
  return out;
}

std::expected<JointVector, std::string> SphericalWristInverse::nearest(const Eigen::Isometry3d& X_BF,
                                                                       const JointVector& q_near) const {
  const Solutions solutions = all(X_BF, q_near);
  if (solutions.count == 0) return std::unexpected("the pose is out of the arm's reach");
  JointVector best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (int k = 0; k < solutions.count; ++k) {
    JointVector q = solutions.q[static_cast<std::size_t>(k)];
    for (Eigen::Index i = 0; i < 6; ++i) {
      q[i] = turned_into_limits(robot_.joints[static_cast<std::size_t>(i)], q[i], q_near[i]);
    }
    const double distance = (q - q_near).squaredNorm();  // NaN, and so never the best, outside the limits
    if (distance < best_distance) {
      best_distance = distance;
      best = q;
    }
  }
  if (best.size() == 0) return std::unexpected("every solution of the pose is beyond a joint limit");
  return best;
}

}  // namespace truepose
