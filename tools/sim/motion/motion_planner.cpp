#include "tools/sim/motion/motion_planner.hpp"

#include <algorithm>
#include <cmath>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"
#include "tools/sim/motion/joint_spline.hpp"

namespace truepose::sim {
namespace {

/// Of a motion without way: programs in a loop of such motions take time too.
constexpr std::chrono::milliseconds kLeastDuration{4};

using krl::MotionKind;

constexpr int kDefaultApproximation_percent = 50;
constexpr Seconds kBrakingOfAxes{0.5};  // of a JointMotion from full speed
constexpr double kDefaultSpeed_mm_s = 250, kDefaultAcceleration_mm_s2 = 1000;
// Pieces whose directions differ by more meet in a corner.
constexpr double kCorner_rad = 1e-3;
// Of each piece, at least, where a path is looked at before the arm is sent along it.
constexpr int kLooks = 50;

Eigen::Isometry3d frame(const std::optional<krl::FrameValues>& values) {
  const krl::FrameValues v = values.value_or(krl::FrameValues{});
  return pose_from_kuka({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
}

bool is_approximated(const krl::Motion& motion) { return motion.approximation != krl::Approximation::None; }

bool is_relative(const krl::Motion& motion) {
  return motion.kind == MotionKind::PtpRel || motion.kind == MotionKind::LinRel;
}

/// Behind `before`, along the axes of the tool.
Eigen::Isometry3d in_tool(const krl::PoseTarget& target, const Eigen::Isometry3d& before) {
  const auto by = [&](std::size_t i) { return target.pose[i].value_or(0); };
  return before * pose_from_kuka({by(0), by(1), by(2)}, {by(3), by(4), by(5)});
}

double share_of_speed(const krl::Motion& motion) {
  return std::clamp(motion.velocity_percent[0], 1, 100) / 100.0;
}

/// What the program leaves out stays as it is at `before`.
Eigen::Isometry3d pose_of(const krl::PoseTarget& target, const Eigen::Isometry3d& before, bool relative) {
  Eigen::Vector3d xyz_mm = before.translation(), abc_deg = kuka_abc_deg(before.linear());
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const auto reached = [&](double now_there, const std::optional<double>& programmed) {
      return relative ? now_there + programmed.value_or(0) : programmed.value_or(now_there);
    };
    xyz_mm[at] = reached(xyz_mm[at], target.pose[i]);
    abc_deg[at] = reached(abc_deg[at], target.pose[i + 3]);
  }
  return pose_from_kuka(xyz_mm, abc_deg);
}

Eigen::Isometry3d target_of(const krl::Motion& motion, const Eigen::Isometry3d& before) {
  const auto& target = std::get<krl::PoseTarget>(motion.target);
  return motion.is_in_tool ? in_tool(target, before) : pose_of(target, before, is_relative(motion));
}

SplineSegment segment_of(const krl::Motion& motion, const Eigen::Isometry3d& before) {
  using Kind = SplineSegment::Kind;
  SplineSegment segment{.kind = motion.kind == MotionKind::Spl ? Kind::Curve
                                : motion.via                   ? Kind::Arc
                                                               : Kind::Line,
                        .to = target_of(motion, before)};
  if (motion.via) segment.via = pose_of(*motion.via, before, false).translation();
  if (motion.circle_angle_deg) segment.angle_rad = *motion.circle_angle_deg * kRadPerDeg;
  return segment;
}

SpeedLimit limit_of(const krl::Motion& motion, const TcpPath& piece) {
  return {
      .length_mm = piece.length_mm(),
      .speed_mm_s = 1000 * motion.path_velocity_m_s.value_or(kDefaultSpeed_mm_s / 1000),
      .acceleration_mm_s2 = 1000 * motion.path_acceleration_m_s2.value_or(kDefaultAcceleration_mm_s2 / 1000)};
}

/// TIME_BLOCK: makes each part take its share of the whole time, where the arm is fast enough for it.
void keep_times(const std::vector<krl::Motion>& segments, std::vector<SpeedLimit>& limits) {
  const auto end = std::ranges::find_if(segments, [](const auto& s) { return s.time_s.has_value(); });
  if (end == segments.end()) return;
  struct Part {
    std::size_t first = 0, last = 0;
    double wanted_s = 0;
  };
  std::vector<Part> parts;
  std::size_t first = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (!segments[i].time_percent) continue;
    parts.push_back({first, i, *segments[i].time_percent / 100 * *end->time_s});
    first = i + 1;
  }
  const std::vector<SpeedLimit> fastest = limits;
  constexpr int kRounds = 40;  // where parts meet, the speed of one is limited by the other's
  for (int round = 0; round < kRounds; ++round) {
    const SpeedProfile speed{limits};
    double begins_mm = 0;
    std::size_t i = 0;
    for (const Part& part : parts) {
      double ends_mm = begins_mm;
      for (; i <= part.last; ++i) ends_mm += limits[i].length_mm;
      const double lasts_s = (speed.time_at(ends_mm) - speed.time_at(begins_mm)).count();
      for (std::size_t j = part.first; j <= part.last && part.wanted_s > 0; ++j)
        limits[j].speed_mm_s =
            std::min(limits[j].speed_mm_s * lasts_s / part.wanted_s, fastest[j].speed_mm_s);
      begins_mm = ends_mm;
    }
  }
}

bool have_corner(const TcpPath& before, const TcpPath& after) {
  const Eigen::Vector3d a = before.arriving(), b = after.leaving();
  return !a.isZero() && !b.isZero() && std::atan2(a.cross(b).norm(), a.dot(b)) > kCorner_rad;
}

/// The piece at a way along them, and how far along it.
std::pair<const TcpPath&, double> piece_at(const std::vector<TcpPath>& pieces, double mm) {
  std::size_t i = 0;
  while (i + 1 < pieces.size() && mm > pieces[i].length_mm()) mm -= pieces[i++].length_mm();
  const double length_mm = pieces[i].length_mm();
  return {pieces[i], length_mm > 0 ? std::min(mm / length_mm, 1.0) : 1};
}

void add_switches(const krl::Motion& motion, PlannedSwitch::Anchor start, Seconds begins,
                  PlannedSwitch::Anchor end, Seconds ends, PlannedMotion& planned) {
  for (const krl::SwitchingPoint& point : motion.switching)
    planned.switches.push_back({.number = point.number,
                                .anchor = point.from_start ? start : end,
                                .inside = point.from_start ? begins : ends,
                                .path_mm = point.path_mm,
                                .delay = Seconds{point.delay_s}});
}

/// @param end_of  when a segment ends
void add_switches(const krl::Motion& motion, const std::function<Seconds(std::size_t segment)>& end_of,
                  PlannedMotion& planned) {
  using Anchor = PlannedSwitch::Anchor;
  add_switches(motion, Anchor::Start, Seconds{0}, Anchor::End, Seconds{0}, planned);
  for (std::size_t i = 0; i < motion.segments.size(); ++i)
    add_switches(motion.segments[i], i == 0 ? Anchor::Start : Anchor::Inside,
                 i == 0 ? Seconds{0} : end_of(i - 1),
                 i + 1 == motion.segments.size() ? Anchor::End : Anchor::Inside, end_of(i), planned);
}

}  // namespace

bool differ(const JointVector& a, const JointVector& b) {
  constexpr double kLeast_rad = 1e-6;  // KRL has 32 bits for an axis
  return (a - b).cwiseAbs().maxCoeff() > kLeast_rad;
}

std::expected<MotionPlanner, std::string> MotionPlanner::of(const RobotModel& nominal) {
  auto inverse = StatusTurnInverse::of(nominal);
  if (!inverse) return std::unexpected(inverse.error());
  return MotionPlanner{nominal, std::make_shared<const StatusTurnInverse>(*std::move(inverse))};
}

std::expected<PlannedMotion, std::string> MotionPlanner::plan(const krl::Motion& motion,
                                                              const JointVector& from) const {
  if (motion.is_tool_fixed && !std::holds_alternative<krl::AxisTarget>(motion.target))
    return std::unexpected("$IPO_MODE #TCP, a tool that stands in the cell, is not simulated");
  const bool of_axes = motion.kind == MotionKind::Ptp || motion.kind == MotionKind::PtpRel;
  auto planned = motion.kind == MotionKind::PtpSpline ? through_axes(motion, from)
                 : of_axes                            ? along_axes(motion, from)
                                                      : along_path(motion, from);
  if (!planned) return planned;
  const bool shifts =
      std::ranges::any_of(planned->switches, [](const PlannedSwitch& s) { return s.path_mm != 0; });
  if (!planned->along && shifts)
    return std::unexpected(
        "PATH of TRIGGER is 0 before motions of the axes, which have no path to count along");
  planned->duration = std::max<Seconds>(planned->duration, kLeastDuration);
  planned->number = motion.number;
  planned->moves_arm = planned->along || differ(from, planned->target);
  return planned;
}

std::expected<PlannedMotion, std::string> MotionPlanner::along_axes(const krl::Motion& motion,
                                                                    const JointVector& from) const {
  const auto target = joints_of(motion, from);
  if (!target) return std::unexpected(target.error());
  const JointMotion joints{nominal_, from, *target, share_of_speed(motion)};
  const double share = motion.approximation_percent.value_or(kDefaultApproximation_percent) / 100.0;
  PlannedMotion planned{.duration = joints.duration(),
                        .path = [joints](Seconds t) { return std::optional{joints.position(t)}; },
                        .target = *target,
                        .blended = is_approximated(motion) ? kBrakingOfAxes * share : Seconds{0}};
  add_switches(motion, {}, planned);
  return planned;
}

std::expected<PlannedMotion, std::string> MotionPlanner::through_axes(const krl::Motion& block,
                                                                      const JointVector& from) const {
  std::vector<JointSpline::Leg> legs;
  JointVector before = from;
  for (const krl::Motion& segment : block.segments) {
    const auto target = joints_of(segment, before);
    if (!target) return std::unexpected(target.error());
    legs.push_back({*target, JointMotion{nominal_, before, *target, share_of_speed(segment)}.duration()});
    before = *target;
  }
  const JointSpline spline{from, legs};
  const double share = block.approximation_percent.value_or(kDefaultApproximation_percent) / 100.0;
  PlannedMotion planned{.duration = spline.duration(),
                        .path = [spline](Seconds t) { return std::optional{spline.position(t)}; },
                        .target = before,
                        .blended = is_approximated(block) ? kBrakingOfAxes * share : Seconds{0}};
  add_switches(
      block, [&](std::size_t i) { return spline.end_of(i); }, planned);
  return planned;
}

std::expected<PlannedMotion, std::string> MotionPlanner::along_path(const krl::Motion& motion,
                                                                    const JointVector& from) const {
  const auto course = course_of(motion, from);
  if (!course) return std::unexpected(course.error());
  const SpeedProfile speed{course->limits};
  const Eigen::Isometry3d base = frame(motion.base), flange = inverse_of(frame(motion.tool));
  // Each point is the solution nearest to the one before it.
  struct Before {
    Seconds t{0};
    JointVector q;
  };
  const auto before = std::make_shared<Before>(Before{Seconds{0}, from});
  const auto joints = [=, pieces = course->pieces,
                       inverse = inverse_](Seconds t) -> std::optional<JointVector> {
    if (t < before->t) before->q = from;
    before->t = t;
    const auto [piece, share] = piece_at(pieces, speed.covered_mm(t));
    const auto q = inverse->solve(base * piece.at(share) * flange, std::nullopt, std::nullopt, before->q);
    if (!q) return std::nullopt;
    return before->q = *q;
  };
  const int looks = kLooks * static_cast<int>(course->pieces.size());
  JointVector target = from;
  for (int look = 0; look <= looks; ++look) {
    const auto q = joints(speed.duration() * (static_cast<double>(look) / looks));
    if (!q) return std::unexpected("the path leaves what the arm can reach");
    target = *q;
  }
  const double near_mm = motion.approximation_distance_mm.value_or(0);
  PlannedMotion planned{.duration = speed.duration(),
                        .path = joints,
                        .target = target,
                        .along = speed,
                        .blended = is_approximated(motion)
                                       ? speed.duration() - speed.time_at(speed.length_mm() - near_mm)
                                       : Seconds{0}};
  std::vector<double> ends_mm;
  for (const TcpPath& piece : course->pieces)
    ends_mm.push_back((ends_mm.empty() ? 0 : ends_mm.back()) + piece.length_mm());
  add_switches(
      motion, [&](std::size_t i) { return speed.time_at(ends_mm[i]); }, planned);
  return planned;
}

std::expected<MotionPlanner::Course, std::string> MotionPlanner::course_of(const krl::Motion& motion,
                                                                           const JointVector& from) const {
  const std::vector<krl::Motion> alone{motion};
  const std::vector<krl::Motion>& parts = motion.segments.empty() ? alone : motion.segments;
  const Eigen::Isometry3d start = tcp(motion, from);
  std::vector<SplineSegment> segments;
  for (const krl::Motion& part : parts) {
    if (part.tool != motion.tool || part.base != motion.base)
      return std::unexpected("another $TOOL or $BASE inside of a spline block is not simulated");
    segments.push_back(segment_of(part, segments.empty() ? start : segments.back().to));
  }
  auto pieces = spline_path(start, segments);
  if (!pieces) return std::unexpected(pieces.error());
  Course course{.pieces = *std::move(pieces), .limits = {}};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    course.limits.push_back(limit_of(parts[i], course.pieces[i]));
    course.limits.back().stops = i + 1 < parts.size() && have_corner(course.pieces[i], course.pieces[i + 1]);
  }
  keep_times(parts, course.limits);
  return course;
}

std::expected<JointVector, std::string> MotionPlanner::joints_of(const krl::Motion& motion,
                                                                 const JointVector& from) const {
  if (const auto* target = std::get_if<krl::PoseTarget>(&motion.target)) {
    const Eigen::Isometry3d X = target_of(motion, tcp(motion, from));
    return inverse_->solve(frame(motion.base) * X * inverse_of(frame(motion.tool)), target->status,
                           target->turn, from);
  }
  const auto& axes = std::get<krl::AxisTarget>(motion.target).axes;
  JointVector q = from;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (const auto& deg = axes[static_cast<std::size_t>(i)])
      q[i] = (is_relative(motion) ? from[i] : 0) + *deg * kRadPerDeg;
  }
  if (!within_limits(nominal_, q)) return std::unexpected("an axis would leave its limits");
  return q;
}

/// In the base.
Eigen::Isometry3d MotionPlanner::tcp(const krl::Motion& motion, const JointVector& q) const {
  return inverse_of(frame(motion.base)) * forward_kinematics(nominal_, q) * frame(motion.tool);
}

}  // namespace truepose::sim
