#include "core/diagnosis/mistakes.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/data/calibrated_cell.hpp"
#include "core/math/angles.hpp"

namespace truepose {
namespace {

constexpr std::size_t kMostJointsForAllSigns = 8;  // 2^8 combinations are tried in milliseconds

std::string number_text(double value, double step = 1e-4) {
  std::string text = std::to_string(std::round(value / step) * step);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string joint_text(std::size_t i) { return std::to_string(i + 1); }
std::string column_text(Eigen::Index i) {
  std::string text{'q'};
  return text += std::to_string(i + 1);
}
double turn_deg(double rad) { return std::remainder(rad, 2 * std::numbers::pi) * kDegPerRad; }
std::string degrees_text(double rad) { return number_text(turn_deg(rad)) + " deg"; }

bool turns(const Joint& joint) { return joint.type == JointType::Revolute; }

/// A mistake whose words do not depend on what is fitted.
Mistake mistake(MistakenFile file, int joint, std::string key, MistakeWords words,
                std::function<void(ModelAndPoints&)> apply_fix) {
  return {.file = file,
          .joint = joint,
          .key = std::move(key),
          .apply_fix = std::move(apply_fix),
          .words = [words = std::move(words)](const RobotModel&, const ModelAndPoints&) { return words; }};
}

Mistake of_joint(std::size_t i, std::string key, MistakeWords words, std::function<void(Joint&)> apply_fix) {
  return mistake(
      MistakenFile::Robot, static_cast<int>(i), std::move(key), std::move(words),
      [i, apply_fix = std::move(apply_fix)](ModelAndPoints& given) { apply_fix(given.arm.joints[i]); });
}

Mistake turned_sign(const Joint& joint, std::size_t i) {
  return of_joint(i, "sign",
                  {"joint " + joint_text(i) + (turns(joint) ? " turns" : " moves") + " the other way",
                   "sign " + number_text(-joint.sign)},
                  [](Joint& fixed) { fixed.sign *= -1; });
}

void add_alphas(const RobotModel& robot, std::vector<Mistake>& mistakes) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const double alpha = robot.joints[i].alpha_rad;
    if (std::abs(std::sin(alpha)) < 1e-9) continue;  // 0 and 180 deg are their own opposites
    mistakes.push_back(
        of_joint(i, "alpha",
                 {"alpha of joint " + joint_text(i) + " has the wrong sign", "alpha " + degrees_text(-alpha)},
                 [](Joint& joint) { joint.alpha_rad *= -1; }));
  }
}

void add_swapped_lengths(const RobotModel& robot, std::vector<Mistake>& mistakes) {
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    const Joint& joint = robot.joints[i];
    if (joint.a_mm == joint.d_mm) continue;
    mistakes.push_back(
        of_joint(i, "a, d",
                 {"a and d of joint " + joint_text(i) + " are swapped",
                  "a " + number_text(joint.d_mm) + " mm and d " + number_text(joint.a_mm) + " mm"},
                 [](Joint& fixed) { std::swap(fixed.a_mm, fixed.d_mm); }));
  }
}

// ---- Conventions of the robot file

/// From rows as standard DH has them, or with `a` and `alpha` one row too early: what turns and shifts behind
/// a joint belongs to the next row, that of the last one to the flange.
void take_behind(RobotModel& arm) {
  Joint before;  // of the first row
  for (Joint& joint : arm.joints) {
    std::swap(joint.a_mm, before.a_mm);
    std::swap(joint.alpha_rad, before.alpha_rad);
  }
  const Eigen::Isometry3d X =
      Eigen::Translation3d(before.a_mm, 0, 0) * Eigen::Isometry3d{rotation_zyx(0, 0, before.alpha_rad)};
  arm.X_flange = X * arm.X_flange;
}

/// From rows whose `a` and `alpha` stand one row too late; what the last row lost is not known.
void take_ahead(RobotModel& arm, double last_alpha_rad) {
  for (std::size_t i = 0; i + 1 < arm.joints.size(); ++i) {
    arm.joints[i].a_mm = arm.joints[i + 1].a_mm;
    arm.joints[i].alpha_rad = arm.joints[i + 1].alpha_rad;
  }
  arm.joints.back().a_mm = 0;
  arm.joints.back().alpha_rad = last_alpha_rad;
}

void add_shifted_rows(std::vector<Mistake>& mistakes) {
  constexpr double kRight = std::numbers::pi / 2;
  mistakes.push_back(of_robot_file("alpha",
                                   {"a and alpha stand one row too early, as in standard DH",
                                    "them one row later, the last ones in the flange"},
                                   take_behind));
  for (const double alpha : {0.0, kRight, -kRight}) {
    mistakes.push_back(
        of_robot_file("alpha",
                      {"a and alpha stand one row too late",
                       "them one row earlier and a 0 mm, alpha " + degrees_text(alpha) + " in the last"},
                      [alpha](RobotModel& arm) { take_ahead(arm, alpha); }));
  }
}

// ---- Columns of the measurements

void add_columns(const RobotModel& robot, std::vector<Mistake>& mistakes) {
  for (Eigen::Index i = 0; i < robot.joint_count(); ++i) {
    for (Eigen::Index j = i + 1; j < robot.joint_count(); ++j) {
      const std::string a = column_text(i), b = column_text(j);
      mistakes.push_back(
          of_points(a + ", " + b,
                    {"the columns " + a + " and " + b + " of the measurements are swapped", "them exchanged"},
                    [i, j](Measurement& point) { std::swap(point.q[i], point.q[j]); }));
    }
  }
  const std::string last = column_text(robot.joint_count() - 1);
  if (robot.joint_count() > 2) {
    mistakes.push_back(of_points(
        "q1 to " + last,
        {"the columns q1 to " + last + " of the measurements are in reversed order", "them turned round"},
        [](Measurement& point) { point.q.reverseInPlace(); }));
  }
  mistakes.push_back(of_points("x, y, z",
                               {"the points are left-handed: two of the columns x, y and z are swapped, or "
                                "one has the wrong sign",
                                "x and y exchanged"},
                               [](Measurement& point) { std::swap(point.p_WS_mm.x(), point.p_WS_mm.y()); }));
}

/// A controller that shows a joint against the one before it, as some do for joints 2 and 3.
void add_couplings(const RobotModel& robot, std::vector<Mistake>& mistakes) {
  for (int i = 1; i < robot.joint_count(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto of_it = [i](const JointCoupling& each) { return each.joint == i; };
    if (!turns(robot.joints[k]) || !turns(robot.joints[k - 1]) || std::ranges::any_of(robot.coupling, of_it))
      continue;
    for (const double factor : {1.0, -1.0}) {
      const std::string entry = "{joint: " + joint_text(k) + ", to: " + joint_text(k - 1) +
                                ", factor: " + number_text(factor) + "}";
      mistakes.push_back(mistake(
          MistakenFile::Robot, -1, "coupling",
          {"joint " + joint_text(k) + " is coupled to joint " + joint_text(k - 1), "coupling " + entry},
          [i, factor](ModelAndPoints& given) {
            given.arm.coupling.push_back({i, i - 1, factor});
          }));
    }
  }
}

Mistake turned_signs(const RobotModel& robot, std::uint32_t which) {
  std::string joints;
  int first = -1;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    if ((which >> i & 1U) == 0) continue;
    if (first < 0) first = static_cast<int>(i);
    const bool last = which >> i == 1;
    joints += (joints.empty() ? "" : last ? " and " : ", ") + joint_text(i);
  }
  return mistake(MistakenFile::Robot, first, "sign",
                 {"joints " + joints + " turn the other way", "their signs changed"},
                 [which](ModelAndPoints& given) {
                   for (std::size_t i = 0; i < given.arm.joints.size(); ++i) {
                     if ((which >> i & 1U) != 0) given.arm.joints[i].sign *= -1;
                   }
                 });
}

// ---- Values left open

using enum ParameterLayout::LinkEntry;
using LinkEntry = ParameterLayout::LinkEntry;

int link_parameter(std::size_t joint, LinkEntry entry) {
  return ParameterLayout::kLink * static_cast<int>(joint) + entry;
}

double Joint::*entry_of(LinkEntry entry) {
  return entry == kA ? &Joint::a_mm : entry == kD ? &Joint::d_mm : &Joint::theta_rad;
}

/// Where an entry stands before and after it was open.
struct Found {
  double before = 0, after = 0;
};

Found found(const ModelAndPoints& fixed, std::size_t i, LinkEntry entry) {
  const auto at = std::ranges::find(fixed.open, link_parameter(i, entry)) - fixed.open.begin();
  return {fixed.before[static_cast<std::size_t>(at)], fixed.arm.joints[i].*entry_of(entry)};
}

/// @param start  of the fit, counted from the value that stands there
Mistake open_mistake(std::size_t i, LinkEntry entry, const std::string& key, double start,
                     std::function<MistakeWords(const Found&)> words) {
  return {
      .file = MistakenFile::Robot,
      .joint = static_cast<int>(i),
      .key = key,
      .apply_fix =
          [i, entry, start](ModelAndPoints& given) {
            double& value = given.arm.joints[i].*entry_of(entry);
            given.open.push_back(link_parameter(i, entry));
            given.before.push_back(value);
            value += start;
          },
      .words = [i, entry, words = std::move(words)](
                   const RobotModel&, const ModelAndPoints& fixed) { return words(found(fixed, i, entry)); }};
}

/// A zero that is sought from several angles, since a fit finds the nearest one alone.
void add_open_zeros(std::size_t i, std::vector<Mistake>& mistakes) {
  constexpr int kStarts = 8;
  const auto words = [i](const Found& theta) {
    return MistakeWords{"theta of joint " + joint_text(i) + " is off by " +
                            number_text(turn_deg(theta.before - theta.after), 0.1) + " deg",
                        "theta " + number_text(turn_deg(theta.after), 0.1) + " deg"};
  };
  for (int k = 0; k < kStarts; ++k)
    mistakes.push_back(open_mistake(i, kTheta, "theta", 2 * std::numbers::pi * k / kStarts, words));
}

void add_open_length(std::size_t i, LinkEntry entry, const std::string& key, std::vector<Mistake>& mistakes) {
  mistakes.push_back(open_mistake(i, entry, key, 0, [i, key](const Found& length) {
    return MistakeWords{key + " of joint " + joint_text(i) + " is off by " +
                            number_text(length.before - length.after, 0.1) + " mm",
                        key + " " + number_text(length.after, 0.1) + " mm"};
  }));
}

}  // namespace

Mistake of_robot_file(std::string key, MistakeWords words, std::function<void(RobotModel&)> apply_fix) {
  return mistake(MistakenFile::Robot, -1, std::move(key), std::move(words),
                 [apply_fix = std::move(apply_fix)](ModelAndPoints& given) { apply_fix(given.arm); });
}

Mistake of_points(std::string columns, MistakeWords words, std::function<void(Measurement&)> apply_fix) {
  return mistake(MistakenFile::Measurements, -1, std::move(columns), std::move(words),
                 [apply_fix = std::move(apply_fix)](ModelAndPoints& given) {
                   std::ranges::for_each(given.points, apply_fix);
                 });
}

std::vector<Mistake> sign_mistakes(const RobotModel& robot) {
  std::vector<Mistake> mistakes;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) mistakes.push_back(turned_sign(robot.joints[i], i));
  return mistakes;
}

std::vector<Mistake> zero_mistakes(const RobotModel& robot) {
  constexpr double kRight = std::numbers::pi / 2;
  std::vector<Mistake> mistakes;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    for (const double error : {kRight, -kRight, 2 * kRight}) {
      mistakes.push_back(of_joint(i, "theta", {}, [error](Joint& joint) { joint.theta_rad -= error; }));
      mistakes.back().words = [i, error](const RobotModel&, const ModelAndPoints& fixed) {
        return MistakeWords{"theta of joint " + joint_text(i) + " is off by " + degrees_text(error),
                            "theta " + degrees_text(fixed.arm.joints[i].theta_rad)};
      };
    }
  }
  return mistakes;
}

std::vector<Mistake> row_mistakes(const RobotModel& robot) {
  std::vector<Mistake> mistakes = sign_mistakes(robot);
  std::ranges::move(zero_mistakes(robot), std::back_inserter(mistakes));
  add_alphas(robot, mistakes);
  add_swapped_lengths(robot, mistakes);
  return mistakes;
}

std::vector<Mistake> open_mistakes(const RobotModel& robot) {
  std::vector<Mistake> mistakes;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    add_open_zeros(i, mistakes);
    add_open_length(i, kA, "a", mistakes);
    add_open_length(i, kD, "d", mistakes);
  }
  return mistakes;
}

std::vector<Mistake> convention_mistakes() {
  std::vector<Mistake> mistakes;
  add_shifted_rows(mistakes);
  return mistakes;
}

std::vector<Mistake> column_mistakes(const RobotModel& robot) {
  std::vector<Mistake> mistakes;
  add_columns(robot, mistakes);
  add_couplings(robot, mistakes);
  return mistakes;
}

std::vector<Mistake> sign_set_mistakes(const RobotModel& robot) {
  std::vector<Mistake> mistakes;
  const std::size_t joints = robot.joints.size();
  const int most = joints <= kMostJointsForAllSigns ? static_cast<int>(joints) : 2;
  for (int turned = 2; turned <= most; ++turned) {
    for (std::uint32_t which = 0; which < 1U << joints; ++which) {
      if (std::popcount(which) == turned) mistakes.push_back(turned_signs(robot, which));
    }
  }
  return mistakes;
}

}  // namespace truepose
