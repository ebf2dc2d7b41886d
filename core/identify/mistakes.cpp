#include "core/identify/mistakes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/math/angles.hpp"

namespace truepose {
namespace {

using Points = std::vector<Measurement>;

constexpr double kMmPerInch = 25.4;
constexpr double kMmPerMetre = 1000;
constexpr std::size_t kMostJointsForAllSigns = 8;  // 2^8 combinations are tried in milliseconds

std::string number_text(double value) {
  std::string text = std::to_string(std::round(value * 1e4) / 1e4);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string joint_text(std::size_t i) { return std::to_string(i + 1); }
std::string degrees_text(double rad) {
  return number_text(std::remainder(rad, 2 * std::numbers::pi) * kDegPerRad) + " deg";
}

Mistake turned_sign(const RobotModel& robot, std::size_t i) {
  const Joint& joint = robot.joints[i];
  const std::string how = joint.type == JointType::Revolute ? " turns the other way: with sign "
                                                            : " moves the other way: with sign ";
  return {"joint " + joint_text(i) + how + number_text(-joint.sign),
          [i](RobotModel& arm, Points&) { arm.joints[i].sign *= -1; }};
}

constexpr double kRightAngle = std::numbers::pi / 2;
constexpr double kZeroErrors[] = {kRightAngle, -kRightAngle, 2 * kRightAngle};

void add_zeros(const RobotModel& robot, std::vector<Mistake>& mistakes) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    for (const double error : kZeroErrors) {
      const double theta = robot.joints[i].theta_rad;
      mistakes.push_back({"theta of joint " + joint_text(i) + " is off by " + degrees_text(error) +
                              ": with " + degrees_text(theta - error) + " instead of " + degrees_text(theta),
                          [i, error](RobotModel& arm, Points&) { arm.joints[i].theta_rad -= error; }});
    }
  }
}

void add_alphas(const RobotModel& robot, std::vector<Mistake>& mistakes) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const double alpha = robot.joints[i].alpha_rad;
    if (std::abs(std::sin(alpha)) < 1e-9) continue;  // 0 and 180 deg are their own opposites
    mistakes.push_back(
        {"alpha of joint " + joint_text(i) + " has the wrong sign: with " + degrees_text(-alpha),
         [i](RobotModel& arm, Points&) { arm.joints[i].alpha_rad *= -1; }});
  }
}

void add_swapped_lengths(const RobotModel& robot, std::vector<Mistake>& mistakes) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    if (joint.a_mm == joint.d_mm) continue;
    mistakes.push_back(
        {"a and d of joint " + joint_text(i) + " are swapped: with a " + number_text(joint.d_mm) +
             " mm and d " + number_text(joint.a_mm) + " mm",
         [i](RobotModel& arm, Points&) { std::swap(arm.joints[i].a_mm, arm.joints[i].d_mm); }});
  }
}

void add_swapped_columns(const RobotModel& robot, std::vector<Mistake>& mistakes) {
  for (Eigen::Index i = 0; i < robot.joint_count(); ++i) {
    for (Eigen::Index j = i + 1; j < robot.joint_count(); ++j) {
      mistakes.push_back({"the columns q" + std::to_string(i + 1) + " and q" + std::to_string(j + 1) +
                              " of the measurements are swapped: with them exchanged",
                          [i, j](RobotModel&, Points& points) {
                            for (Measurement& point : points) std::swap(point.q[i], point.q[j]);
                          }});
    }
  }
}

void scale_joint_angles(const RobotModel& arm, double factor, Points& points) {
  for (Eigen::Index i = 0; i < arm.joint_count(); ++i) {
    if (arm.joints[static_cast<std::size_t>(i)].type == JointType::Prismatic) continue;
    for (Measurement& point : points) point.q[i] *= factor;
  }
}

void add_units(std::vector<Mistake>& mistakes) {
  mistakes.push_back({"the joint angles of the measurements are in rad, not deg: with them converted",
                      [](RobotModel& arm, Points& points) { scale_joint_angles(arm, kDegPerRad, points); }});
  mistakes.push_back(
      {"the angles of the robot file are in rad, not deg: with them converted", [](RobotModel& arm, Points&) {
         for (Joint& joint : arm.joints) {
           for (double* angle : {&joint.alpha_rad, &joint.theta_rad, &joint.beta_rad}) *angle *= kDegPerRad;
         }
       }});
  for (const auto& [unit, mm] : {std::pair{"m", kMmPerMetre}, std::pair{"inches", kMmPerInch}}) {
    mistakes.push_back({std::string("the points are in ") + unit + ", not mm: with them converted",
                        [mm](RobotModel&, Points& points) {
                          for (Measurement& point : points) point.p_WS_mm *= mm;
                        }});
    mistakes.push_back(
        {std::string("the lengths of the robot file are in ") + unit + ", not mm: with them converted",
         [mm](RobotModel& arm, Points&) {
           for (Joint& joint : arm.joints) {
             joint.a_mm *= mm;
             joint.d_mm *= mm;
           }
           arm.X_flange.translation() *= mm;
         }});
  }
}

Mistake turned_signs(const RobotModel& robot, std::uint32_t which) {
  std::string joints;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    if ((which >> i & 1U) == 0) continue;
    const bool last = which >> i == 1;
    joints += (joints.empty() ? "" : last ? " and " : ", ") + joint_text(i);
  }
  return {"joints " + joints + " turn the other way: with their signs changed",
          [which](RobotModel& arm, Points&) {
            for (std::size_t i = 0; i < arm.joints.size(); ++i) {
              if ((which >> i & 1U) != 0) arm.joints[i].sign *= -1;
            }
          }};
}

}  // namespace

std::vector<Mistake> sign_mistakes(const RobotModel& robot) {
  std::vector<Mistake> mistakes;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) mistakes.push_back(turned_sign(robot, i));
  return mistakes;
}

std::vector<Mistake> single_mistakes(const RobotModel& robot) {
  std::vector<Mistake> mistakes = sign_mistakes(robot);
  add_zeros(robot, mistakes);
  add_alphas(robot, mistakes);
  add_swapped_lengths(robot, mistakes);
  add_swapped_columns(robot, mistakes);
  add_units(mistakes);
  return mistakes;
}

std::vector<Mistake> combined_mistakes(const RobotModel& robot) {
  std::vector<Mistake> mistakes;
  const std::size_t joints = robot.joints.size();
  const int most = joints <= kMostJointsForAllSigns ? static_cast<int>(joints) : 2;
  for (int turned = 2; turned <= most; ++turned) {
    for (std::uint32_t which = 0; which < 1U << joints; ++which) {
      if (std::popcount(which) == turned) mistakes.push_back(turned_signs(robot, which));
    }
  }
  for (std::size_t i = 0; i < joints; ++i) {
    for (const double error : kZeroErrors) {
      const double theta = robot.joints[i].theta_rad;
      mistakes.push_back({turned_sign(robot, i).what + " and theta " + degrees_text(theta - error),
                          [i, error](RobotModel& arm, Points&) {
                            arm.joints[i].sign *= -1;
                            arm.joints[i].theta_rad -= error;
                          }});
    }
  }
  return mistakes;
}

}  // namespace truepose
