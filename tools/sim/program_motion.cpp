#include "tools/sim/program_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/arm/forward.hpp"
#include "core/math/angles.hpp"

namespace truepose::sim {
namespace {

constexpr int kReducedPercent = 10;
constexpr double kReduced_m_s = 0.25;
constexpr double kDefaultSpeed_mm_s = 250, kDefaultAcceleration_mm_s2 = 1000;
// As fast as the path's own speed turns a metre.
constexpr double kRadius_mm = 1000;

Eigen::Isometry3d frame(const std::optional<krl::FrameValues>& values) {
  const krl::FrameValues v = values.value_or(krl::FrameValues{});
  return pose_from_kuka({v[0], v[1], v[2]}, {v[3], v[4], v[5]});
}

/// The way covered at a time, 0..1, of a trapezoid of speed.
class Trapezoid {
 public:
  Trapezoid(double way, double speed, double acceleration) {
    if (way <= 0) return;
    const double ramp_s = std::min(speed / acceleration, std::sqrt(way / acceleration));
    ramp_ = Seconds{ramp_s};
    peak_ = acceleration * ramp_s / way;
    duration_ = Seconds{1 / peak_ + ramp_s};
  }
  Seconds duration() const { return duration_; }
  double covered(Seconds t) const {
    if (t >= duration_) return 1;
    const double ramp = ramp_.count(), now = t.count(), left = (duration_ - t).count();
    if (now < ramp) return 0.5 * peak_ / ramp * now * now;
    if (left < ramp) return 1 - 0.5 * peak_ / ramp * left * left;
    return peak_ * (now - ramp / 2);
  }

 private:
  Seconds ramp_{0}, duration_{0};
  double peak_ = 0;  // shares of the way in a second
};

/// Where the TCP is at a share of its way in the base: straight, or on the circle through `via`.
class TcpPath {
 public:
  TcpPath(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to,
          const std::optional<Eigen::Vector3d>& via)
      : from_{from}, to_{to.translation()}, turn_{turn_between(from.linear(), to.linear())} {
    if (via) bend(*via);
  }

  double length_mm() const {
    const double way = angle_ > 0 ? angle_ * arm_.norm() : (to_ - from_.translation()).norm();
    return std::max(way, kRadius_mm * turn_.norm());
  }
  Eigen::Isometry3d at(double share) const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = rotation_by(share * turn_) * from_.linear();
    X.translation() = angle_ > 0 ? Eigen::Vector3d{centre_ + rotation_by(share * angle_ * axis_) * arm_}
                                 : Eigen::Vector3d{from_.translation() + share * (to_ - from_.translation())};
    return X;
  }

 private:
  /// The circle through three points; a straight line where they are in one.
  void bend(const Eigen::Vector3d& via) {
    const Eigen::Vector3d a = via - from_.translation(), b = to_ - from_.translation();
    const Eigen::Vector3d normal = a.cross(b);
    if (normal.norm() < 1e-9 * a.norm() * b.norm()) return;
    const Eigen::Vector3d to_centre =
        (a.squaredNorm() * b - b.squaredNorm() * a).cross(normal) / (2 * normal.squaredNorm());
    centre_ = from_.translation() + to_centre;
    arm_ = -to_centre;
    axis_ = normal.normalized();
    const Eigen::Vector3d end = to_ - centre_;
    angle_ = std::atan2(arm_.cross(end).dot(axis_), arm_.dot(end));
    if (angle_ <= 0) angle_ += 2 * std::numbers::pi;
  }

  Eigen::Isometry3d from_;
  Eigen::Vector3d to_;
  Eigen::Vector3d turn_;
  Eigen::Vector3d centre_{0, 0, 0}, arm_{0, 0, 0}, axis_{0, 0, 1};
  double angle_ = 0;  // 0: straight
};

}  // namespace

bool differ(const JointVector& a, const JointVector& b) {
  constexpr double kLeast_rad = 1e-6;  // KRL has 32 bits for an axis
  return (a - b).cwiseAbs().maxCoeff() > kLeast_rad;
}

std::expected<ProgramMotion, std::string> ProgramMotion::of(const RobotModel& nominal, const JointVector& q) {
  auto inverse = StatusTurnInverse::of(nominal);
  if (!inverse) return std::unexpected(inverse.error());
  return ProgramMotion{nominal, std::make_shared<const StatusTurnInverse>(*std::move(inverse)), q};
}

std::expected<void, std::string> ProgramMotion::take(krl::Motion motion, bool reduced) {
  if (reduced) {
    for (int& percent : motion.velocity_percent) percent = std::min(percent, kReducedPercent);
    motion.path_velocity_m_s = std::min(motion.path_velocity_m_s.value_or(kReduced_m_s), kReduced_m_s);
  }
  auto target = joints_of(motion);
  if (!target) return std::unexpected(target.error());
  const bool of_axes = motion.kind == krl::MotionKind::Ptp || motion.kind == krl::MotionKind::PtpRel;
  Making making = of_axes ? along_axes(motion, *target) : along_path(motion, *target);
  // A path is looked at before the arm is sent along it.
  for (Seconds t{0}; t < making.duration; t += making.duration / 50) {
    if (!making.path(t)) return std::unexpected("the path leaves what the arm can reach");
  }
  making.moves_arm = differ(end_, *target) || !making.is_of_axes;
  if (waiting_.empty()) since_ = Seconds{0};
  waiting_.push_back(std::move(making));
  end_ = *target;
  return {};
}

bool ProgramMotion::is_finished(std::uint64_t motion) const {
  return std::ranges::none_of(waiting_, [motion](const Making& making) { return making.number == motion; });
}

void ProgramMotion::cancel() {
  waiting_.clear();
  end_ = q_;
  braked_ = false;
  rate_ = override_;
}

void ProgramMotion::place(const JointVector& q) {
  q_ = q;
  cancel();
}

std::optional<Seconds> ProgramMotion::until_change(Seconds cycle) const {
  if (is_standing()) return std::nullopt;
  const double wanted = braked_ ? 0 : override_;
  if (rate_ != wanted) return cycle;
  if (rate_ == 0) return std::nullopt;
  const Seconds left = (waiting_.front().duration - since_) / rate_;
  return waiting_.front().is_of_axes ? left : std::min(left, cycle);
}

const JointVector& ProgramMotion::advance(Seconds cycle) {
  const double change = cycle / kBraking, wanted = braked_ ? 0 : override_;
  rate_ = wanted > rate_ ? std::min(rate_ + change, wanted) : std::max(rate_ - change, wanted);
  if (waiting_.empty()) return q_;
  since_ += rate_ * cycle;
  const Making& making = waiting_.front();
  if (since_ < making.duration) {
    q_ = making.path(since_).value_or(q_);
    return q_;
  }
  q_ = making.target;
  since_ = Seconds{0};
  moved_ += making.moves_arm;
  waiting_.pop_front();
  ++made_;
  return q_;
}

std::expected<JointVector, std::string> ProgramMotion::joints_of(const krl::Motion& motion) const {
  const bool relative = motion.kind == krl::MotionKind::PtpRel || motion.kind == krl::MotionKind::LinRel;
  if (relative) return std::unexpected("relative motions cannot be made here");
  if (const auto* target = std::get_if<krl::PoseTarget>(&motion.target)) return joints_at(*target, motion);
  const auto& axes = std::get<krl::AxisTarget>(motion.target).axes;
  JointVector q = end_;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (const auto& deg = axes[static_cast<std::size_t>(i)]) q[i] = *deg * kRadPerDeg;
  }
  if (!within_limits(nominal_, q)) return std::unexpected("an axis would leave its limits");
  return q;
}

Eigen::Isometry3d ProgramMotion::tcp_of(const krl::PoseTarget& target, const krl::Motion& motion) const {
  // What the program leaves out stays as it is.
  const Eigen::Isometry3d now =
      inverse_of(frame(motion.base)) * forward_kinematics(nominal_, end_) * frame(motion.tool);
  Eigen::Vector3d xyz_mm = now.translation(), abc_deg = kuka_abc_deg(now.linear());
  for (std::size_t i = 0; i < 3; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    xyz_mm[at] = target.pose[i].value_or(xyz_mm[at]);
    abc_deg[at] = target.pose[i + 3].value_or(abc_deg[at]);
  }
  return pose_from_kuka(xyz_mm, abc_deg);
}

std::expected<JointVector, std::string> ProgramMotion::joints_at(const krl::PoseTarget& target,
                                                                 const krl::Motion& motion) const {
  const Eigen::Isometry3d X_BF = frame(motion.base) * tcp_of(target, motion) * inverse_of(frame(motion.tool));
  const bool point_to_point = motion.kind == krl::MotionKind::Ptp;  // a path has no choice
  return inverse_->solve(X_BF, point_to_point ? target.status : std::nullopt,
                         point_to_point ? target.turn : std::nullopt, end_);
}

ProgramMotion::Making ProgramMotion::along_axes(const krl::Motion& motion, const JointVector& target) const {
  const double scale = std::clamp(motion.velocity_percent[0], 1, 100) / 100.0;
  const JointMotion joints{nominal_, end_, target, scale};
  return {.number = motion.number,
          .duration = joints.duration(),
          .path = [joints](Seconds t) { return std::optional{joints.position(t)}; },
          .target = target};
}

ProgramMotion::Making ProgramMotion::along_path(const krl::Motion& motion, const JointVector& target) const {
  const Eigen::Isometry3d base = frame(motion.base), tool = frame(motion.tool);
  const auto tcp = [&](const JointVector& q) {
    return Eigen::Isometry3d{inverse_of(base) * forward_kinematics(nominal_, q) * tool};
  };
  std::optional<Eigen::Vector3d> via;
  if (motion.via) via = tcp_of(*motion.via, motion).translation();
  const TcpPath path{tcp(end_), tcp(target), via};
  const Trapezoid speed{path.length_mm(), 1000 * motion.path_velocity_m_s.value_or(kDefaultSpeed_mm_s / 1000),
                        1000 * motion.path_acceleration_m_s2.value_or(kDefaultAcceleration_mm_s2 / 1000)};
  const Eigen::Isometry3d flange = inverse_of(tool);
  // Each point is the solution nearest to the one before it.
  struct Before {
    Seconds t{0};
    JointVector q;
  };
  const auto before = std::make_shared<Before>(Before{Seconds{0}, end_});
  const auto joints = [=, start = end_, inverse = inverse_](Seconds t) -> std::optional<JointVector> {
    if (t < before->t) before->q = start;
    before->t = t;
    const auto q =
        inverse->solve(base * path.at(speed.covered(t)) * flange, std::nullopt, std::nullopt, before->q);
    if (!q) return std::nullopt;
    return before->q = *q;
  };
  return {.number = motion.number,
          .duration = speed.duration(),
          .path = joints,
          .target = target,
          .is_of_axes = false};
}

}  // namespace truepose::sim
