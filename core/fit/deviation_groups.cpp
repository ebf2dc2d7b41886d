#include "core/fit/deviation_groups.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/arm/guide.hpp"
#include "core/data/carried_payload.hpp"
#include "core/fit/identifiability.hpp"
#include "core/math/units.hpp"

namespace truepose {
namespace {

// A lever in m, or a torque in kN m, beyond what is left of one that is none.
constexpr double kRounding = 1e-9;
// The bend of a guide that is 0.2 mm off its line in the middle of 5 m is 0.008 mm off in that of 1 m: along
// less, nothing is left that a tracker could see.
constexpr double kShortestGuide_mm = 1000;
// What a guide does beyond where the arm was measured, waves that fit there cannot say, and may say wildly.
constexpr double kMostOfTheWay = 0.75;
// Many guides are next to straight: of those the points may well say so.
constexpr double kGuideLogDeviation = 3;
// Of 10 m; more than so many coefficients of each motion no usual campaign tells.
constexpr int kMostHalfWaves = 20;

std::string joint_name(int i) { return "joint" + std::to_string(i + 1); }

bool approach_varies(std::span<const Measurement> points, std::size_t joint) {
  bool up = false, down = false;
  for (const Measurement& point : points) {
    if (joint >= point.direction.size()) continue;
    up |= point.direction[joint] > 0;
    down |= point.direction[joint] < 0;
  }
  return up && down;
}

/// Values of the bases of `terms` at every point: one row a point.
Eigen::MatrixXd bases_at(const RobotModel& robot, std::vector<DeviationTerm> terms,
                         std::span<const Measurement> points) {
  RobotModel with = robot;
  with.deviation = std::move(terms);
  Eigen::MatrixXd bases(static_cast<Eigen::Index>(with.deviation.size()),
                        static_cast<Eigen::Index>(points.size()));
  LoadedArm arm(with);
  for (std::size_t n = 0; n < points.size(); ++n) {
    double* const of_point = bases.col(static_cast<Eigen::Index>(n)).data();
    deviation_basis(arm.at(points[n]), points[n].q, points[n].direction, {of_point, with.deviation.size()});
  }
  return bases.transpose();
}

/// Those of the columns that vary, by more than rounding, and are independent of one another.
std::vector<int> independent(const Eigen::MatrixXd& bases) {
  const Eigen::Index constant = bases.cols();  // which the joint's zero explains
  Eigen::MatrixXd columns(bases.rows(), constant + 1);
  columns << bases, Eigen::VectorXd::Ones(bases.rows());
  Eigen::VectorXd preference = Eigen::VectorXd::Ones(constant + 1);
  preference[constant] = 1e3;
  std::vector<int> kept;
  for (const int k : identifiability(columns, preference).kept)
    if (k < constant && bases.col(k).cwiseAbs().maxCoeff() > kRounding) kept.push_back(k);
  return kept;
}

/// A payload that changes tells how the joint bends under a known mass, whatever the arm's own.
std::vector<DeviationTerm> weight_terms(const RobotModel& robot, std::span<const Measurement> points, int i) {
  std::vector<DeviationTerm> terms;
  if (!robot.masses.empty() || payload_varies(points)) terms.push_back({i, DeviationBasis::Gravity, 1, 0});
  if (!robot.masses.empty()) return terms;
  for (int frame = i + 2; frame <= robot.joint_count() + 1; ++frame)
    terms.push_back({i, DeviationBasis::Weight, frame, 0});
  return terms;
}

std::vector<DeviationTerm> moment_terms(const RobotModel& robot, int i) {
  std::vector<DeviationTerm> terms;
  for (int frame = i + 1; frame <= robot.joint_count(); ++frame) {
    for (const auto basis : {DeviationBasis::MomentX, DeviationBasis::MomentY, DeviationBasis::MomentZ})
      terms.push_back({i, basis, frame, 0});
  }
  return terms;
}

/// What gravity may do to all joints: terms, and their bases at the points in a column each.
struct Gravity {
  std::vector<DeviationTerm> terms;
  Eigen::MatrixXd bases;
};

Gravity gravity_of(const RobotModel& robot, std::span<const Measurement> points) {
  Gravity gravity;
  for (int i = 0; i < robot.joint_count(); ++i) {
    std::vector<DeviationTerm> terms = weight_terms(robot, points, i);
    if (robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute)
      std::ranges::copy(moment_terms(robot, i), std::back_inserter(terms));
    gravity.terms.insert(gravity.terms.end(), terms.begin(), terms.end());
  }
  gravity.bases = bases_at(robot, gravity.terms, points);
  return gravity;
}

/// Of the terms of one joint and cause those that the points can tell.
void add_gravity(const Gravity& gravity, int i, DeviationCause cause, std::vector<DeviationGroup>& groups) {
  const bool moments = cause == DeviationCause::MassMoments;
  std::vector<std::size_t> mine;
  for (std::size_t k = 0; k < gravity.terms.size(); ++k) {
    const DeviationTerm& term = gravity.terms[k];
    if (term.joint == i && is_moment(term.basis) == moments) mine.push_back(k);
  }
  const Eigen::MatrixXd bases = gravity.bases(Eigen::all, mine);
  const std::vector<int> kept = independent(bases);
  if (kept.empty()) return;
  DeviationGroup group{
      .name = joint_name(i) + (moments ? ".moments" : ".gravity"), .cause = cause, .terms = {}};
  for (const int k : kept) group.terms.push_back(gravity.terms[mine[static_cast<std::size_t>(k)]]);
  group.unit = 1 / bases(Eigen::all, kept).cwiseAbs().maxCoeff();
  groups.push_back(std::move(group));
}

/// Whether the arm was measured along a prismatic joint so far that its guide shows.
bool shows_guide(const RobotModel& robot, std::span<const Measurement> points, int i) {
  if (points.empty()) return false;
  const auto along = [i](const Measurement& point) { return point.q[i]; };
  const auto [least, most] = std::ranges::minmax_element(points, {}, along);
  const Joint& joint = robot.joints[static_cast<std::size_t>(i)];
  const double way = std::min(along(*most), joint.max) - std::max(along(*least), joint.min);
  return way >= std::max(kShortestGuide_mm, kMostOfTheWay * (joint.max - joint.min));
}

/// Guides bend between the supports that they were aligned at, half a metre or more apart.
int half_waves_of(const Joint& joint) {
  constexpr double kPerMetre = 2;
  return std::min(static_cast<int>(kPerMetre * kMetresPerMm * (joint.max - joint.min)), kMostHalfWaves);
}

void add_guide(const RobotModel& robot, int i, std::vector<DeviationGroup>& groups) {
  DeviationGroup bends{
      .name = joint_name(i) + ".straightness", .cause = DeviationCause::Bends, .smooth = true};
  DeviationGroup twists{.name = joint_name(i) + ".guide", .cause = DeviationCause::Twists, .smooth = true};
  const int highest = half_waves_of(robot.joints[static_cast<std::size_t>(i)]);
  for (const GuideMotion& motion : kGuideMotions) {
    for (int order = 1; order <= highest; ++order)
      (motion.turns ? twists : bends).terms.push_back({i, motion.basis, order, 0});
  }
  groups.push_back(std::move(bends));
  groups.push_back(std::move(twists));
}

}  // namespace

WidthExpectation usual_width(DeviationCause cause) {
  switch (cause) {
    case DeviationCause::Gears:
    case DeviationCause::GravityCompliance:
    case DeviationCause::MassMoments:
      return {.usual = 0.1e-3, .log_deviation = 1};
    case DeviationCause::Backlash:
      return {.usual = 0.02e-3, .log_deviation = 1};
    case DeviationCause::Pitch:
      return {.usual = 0.1, .log_deviation = 1.5};
    case DeviationCause::Bends:
      return {.usual = 0.1, .log_deviation = kGuideLogDeviation};
    case DeviationCause::Twists:
      return {.usual = 0.05e-3, .log_deviation = kGuideLogDeviation};
  }
  return {};
}

std::vector<DeviationGroup> deviation_groups(const RobotModel& robot, std::span<const Measurement> points,
                                             std::span<const int> harmonics) {
  const Gravity gravity = gravity_of(robot, points);
  std::vector<DeviationGroup> groups;
  int guides = 0;
  for (int i = 0; i < robot.joint_count(); ++i) {
    const auto joint = static_cast<std::size_t>(i);
    if (robot.joints[joint].type == JointType::Revolute) {
      // Those of a joint that hardly moved too: what the fit cannot tell of them is in what it says of
      // itself.
      for (const int order : harmonics) {
        groups.push_back({joint_name(i) + ".harmonic" + std::to_string(order),
                          DeviationCause::Gears,
                          {{i, DeviationBasis::Sine, order, 0}, {i, DeviationBasis::Cosine, order, 0}}});
      }
    } else {
      groups.push_back({joint_name(i) + ".scale", DeviationCause::Pitch, {{i, DeviationBasis::Scale, 1, 0}}});
      if (guides < kMostGuides && shows_guide(robot, points, i)) {
        add_guide(robot, i, groups);
        ++guides;
      }
    }
    add_gravity(gravity, i, DeviationCause::GravityCompliance, groups);
    add_gravity(gravity, i, DeviationCause::MassMoments, groups);
    if (approach_varies(points, joint)) {
      groups.push_back(
          {joint_name(i) + ".approach", DeviationCause::Backlash, {{i, DeviationBasis::Approach, 1, 0}}});
    }
  }
  return groups;
}

}  // namespace truepose
