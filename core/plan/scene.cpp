#include "core/plan/scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/arm/joint_coupling.hpp"
#include "core/formatted.hpp"
#include "core/math/angles.hpp"
#include "core/step_count.hpp"

namespace truepose {
namespace {

// A segment below this length is a point: its direction is rounding.
constexpr double kPoint_mm2 = 1e-12;

double share(double part, double whole) { return std::clamp(part / whole, 0.0, 1.0); }

}  // namespace

double distance_mm(const Capsule& a, const Capsule& b) {
  const Eigen::Vector3d along_a = a.to_mm - a.from_mm, along_b = b.to_mm - b.from_mm;
  const Eigen::Vector3d between = a.from_mm - b.from_mm;
  const double aa = along_a.squaredNorm(), bb = along_b.squaredNorm(), ab = along_a.dot(along_b);
  const double a_between = along_a.dot(between), b_between = along_b.dot(between);

  // The nearest points, as shares s and t of the segments: s for the endless lines, t for that s, and s again
  // where t had to be clamped to its segment. Parallel lines are as near everywhere: s = 0 serves.
  double s = 0, t = 0;
  if (bb <= kPoint_mm2) {
    s = aa <= kPoint_mm2 ? 0 : share(-a_between, aa);
  } else {
    const double across = aa * bb - ab * ab;
    if (aa > kPoint_mm2 && across > kPoint_mm2 * aa * bb) s = share(ab * b_between - a_between * bb, across);
    t = (ab * s + b_between) / bb;
    if (t < 0 || t > 1) {
      t = std::clamp(t, 0.0, 1.0);
      s = aa <= kPoint_mm2 ? 0 : share(ab * t - a_between, aa);
    }
  }
  return (between + s * along_a - t * along_b).norm() - a.radius_mm - b.radius_mm;
}

namespace {

// Nearer to the last axis the reflector hardly moves when that axis turns.
constexpr double kOffAxis_mm = 20;

constexpr std::array<std::string_view, kPoseFaults> kTexts{"were too near to a joint limit",
                                                           "left the workspace",
                                                           "had the reflector turned away from the tracker",
                                                           "were too near to a wrist singularity",
                                                           "came below the floor",
                                                           "came too near to an obstacle",
                                                           "came too near to the tracker",
                                                           "had the arm too near to itself",
                                                           "had the beam cut"};

double margin_of(const Joint& joint, const Scene& scene) {
  return joint.type == JointType::Revolute ? scene.limit_margin_rad : scene.limit_margin_mm;
}

/// The centres of the joints and of the flange, where nothing more is known of an arm.
std::vector<BodyPart> joint_centres(int joints) {
  std::vector<BodyPart> parts;
  for (int link = 2; link <= joints + 1; ++link) parts.push_back({link, {}});
  return parts;
}

/// Neighbours always touch, and what is mounted on the flange belongs to the last link.
bool may_collide(const BodyPart& a, const BodyPart& b, int joints) {
  return std::abs(std::min(a.link, joints) - std::min(b.link, joints)) >= 2;
}

/// The farthest point of a body from the origin of the frame in which it stands.
double extent_mm(const Capsule& capsule) {
  return std::max(capsule.from_mm.norm(), capsule.to_mm.norm()) + capsule.radius_mm;
}

/// How far each joint moves any point of the arm at most: mm per rad, or per mm. No joint moves one body
/// against another by more than it moves one against the base.
JointVector levers(const Scene& scene, std::span<const BodyPart> parts) {
  const int joints = scene.robot.joint_count();
  const auto extent_of_link_mm = [&](int link) {
    double extent = 0;
    for (const BodyPart& part : parts) {
      if (part.link == link) extent = std::max(extent, extent_mm(part.capsule));
    }
    return extent;
  };
  JointVector levers{joints};
  // From the origin of the link at hand to whatever moves with it.
  double farthest_mm = std::max(extent_of_link_mm(joints + 1), scene.sight.p_FS_mm.norm());
  for (const SightedReflector& reflector : scene.sight.further)
    farthest_mm = std::max(farthest_mm, reflector.p_FS_mm.norm());
  farthest_mm += scene.robot.X_flange.translation().norm();
  for (int link = joints; link > 0; --link) {
    farthest_mm = std::max(farthest_mm, extent_of_link_mm(link));
    const Joint& joint = scene.robot.joints[static_cast<std::size_t>(link - 1)];
    const bool revolute = joint.type == JointType::Revolute;
    const double stroke_mm = revolute ? 0 : std::max(std::abs(joint.min), std::abs(joint.max));
    levers[link - 1] = revolute ? farthest_mm : 1;
    farthest_mm += std::hypot(joint.a_mm, std::abs(joint.d_mm) + stroke_mm);
  }
  return levers;
}

double lowest_mm(const Capsule& capsule) {
  return std::min(capsule.from_mm.z(), capsule.to_mm.z()) - capsule.radius_mm;
}

std::vector<SightedReflector> reflectors_of(const LineOfSight& sight) {
  std::vector<SightedReflector> all{{sight.p_FS_mm, sight.facing_F, sight.acceptance_rad}};
  all.insert(all.end(), sight.further.begin(), sight.further.end());
  for (SightedReflector& reflector : all) reflector.facing_F.normalize();
  return all;
}

/// Of the one that is farthest off: one is enough to show how the last axis turns.
double reflector_off_axis_mm(const Scene& scene) {
  double farthest_mm = 0;
  for (const SightedReflector& reflector : reflectors_of(scene.sight)) {
    const Eigen::Vector3d p_mm = scene.robot.X_flange * reflector.p_FS_mm;  // in the last link's frame
    farthest_mm = std::max(farthest_mm, p_mm.head<2>().norm());
  }
  return farthest_mm;
}

}  // namespace

std::string_view fault_text(PoseFault fault) { return kTexts[static_cast<std::size_t>(fault)]; }

PoseChecker::PoseChecker(Scene scene)
    : scene_{std::move(scene)},
      reflectors_{reflectors_of(scene_.sight)},
      parts_{scene_.body.empty() ? joint_centres(scene_.robot.joint_count()) : scene_.body},
      p_BT_mm_{inverse_of(scene_.sight.X_WB).translation()},
      tracker_{p_BT_mm_,
               {p_BT_mm_.x(), p_BT_mm_.y(), std::min(p_BT_mm_.z(), scene_.surroundings.floor_mm)},
               scene_.surroundings.tracker_radius_mm},
      placed_(parts_.size()),
      lever_{levers(scene_, parts_)} {
  std::ranges::stable_sort(parts_, {}, &BodyPart::link);  // each is compared with those before it
}

std::optional<PoseFault> PoseChecker::fault_of(const JointVector& q, Visibility visibility) {
  if (!within_margins(q)) return PoseFault::JointLimit;
  place(q);
  const Eigen::Vector3d p_BS_mm = X_BF_ * scene_.sight.p_FS_mm;
  const bool to_be_seen = visibility == Visibility::Required;
  if (!scene_.workspace.holds(p_BS_mm)) return PoseFault::OutsideWorkspace;
  const auto faces_tracker = [this](const SightedReflector& reflector) { return faces(reflector); };
  if (to_be_seen && std::ranges::none_of(reflectors_, faces_tracker)) return PoseFault::TurnedAway;
  if (wrist_singular()) return PoseFault::SingularWrist;
  if (const auto collides = collision()) return collides;
  const auto is_seen = [this](const SightedReflector& reflector) { return sees(reflector); };
  if (to_be_seen && std::ranges::none_of(reflectors_, is_seen)) return PoseFault::BeamCut;
  return approach_fault(q);
}

std::optional<PoseFault> PoseChecker::collision_at(const JointVector& q) {
  place(q);
  return collision();
}

double PoseChecker::spare_mm(const JointVector& q) {
  place(q);
  double least = std::numeric_limits<double>::infinity();
  look_about([&](PoseFault, double spare_mm) {
    least = std::min(least, spare_mm);
    return false;
  });
  return least;
}

double PoseChecker::largest_change_mm(const JointVector& way) const {
  return lever_.dot(chain_joints(scene_.robot.coupling, way).cwiseAbs());
}

std::optional<PoseFault> PoseChecker::approach_fault(const JointVector& q) {
  for (const double way_rad : scene_.approach_rad) {
    const JointVector start = approach_start(scene_.robot, q, way_rad);
    if (!within_limits(scene_.robot, start)) return PoseFault::JointLimit;
    if (const auto collides = collision_at(start)) return collides;
  }
  return std::nullopt;
}

void PoseChecker::place(const JointVector& q) {
  count_step();
  link_frames(scene_.robot, q, X_);
  X_BF_ = X_[scene_.robot.joints.size()] * scene_.robot.X_flange;
}

std::vector<int> PoseChecker::seen_at(const JointVector& q) {
  place(q);
  place_parts();
  std::vector<int> seen;
  for (std::size_t k = 0; k < reflectors_.size(); ++k)
    if (sees(reflectors_[k])) seen.push_back(static_cast<int>(k));
  return seen;
}

/// Turned to the tracker, whatever may be between.
bool PoseChecker::faces(const SightedReflector& reflector) const {
  const Eigen::Vector3d to_tracker = (p_BT_mm_ - X_BF_ * reflector.p_FS_mm).normalized();
  return to_tracker.dot(X_BF_.linear() * reflector.facing_F) >= std::cos(reflector.acceptance_rad);
}

bool PoseChecker::sees(const SightedReflector& reflector) const {
  return faces(reflector) && !beam_cut(X_BF_ * reflector.p_FS_mm);
}

bool PoseChecker::within_margins(const JointVector& q) const {
  for (int i = 0; i < scene_.robot.joint_count(); ++i) {
    const Joint& joint = scene_.robot.joints[static_cast<std::size_t>(i)];
    const double margin = margin_of(joint, scene_);
    if (!(q[i] >= joint.min + margin && q[i] <= joint.max - margin)) return false;
  }
  return true;
}

/// Whether axes N-2 and N lie along nearly one line. Arms whose last axes do not cross are not judged: theirs
/// may be parallel by design.
bool PoseChecker::wrist_singular() const {
  const std::vector<Joint>& joints = scene_.robot.joints;
  const std::size_t n = joints.size();
  const auto crosses = [&](std::size_t i) {
    return joints[i].type == JointType::Revolute && std::abs(std::sin(joints[i].alpha_rad)) > 0.5;
  };
  if (n < 3 || joints[n - 3].type != JointType::Revolute || !crosses(n - 2) || !crosses(n - 1)) return false;
  const Eigen::Vector3d z_a = X_[n - 2].linear().col(2), z_b = X_[n].linear().col(2);
  return z_a.cross(z_b).norm() < std::sin(scene_.wrist_margin_rad);
}

void PoseChecker::place_parts() {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const bool on_flange = parts_[i].link > scene_.robot.joint_count();
    placed_[i] = (on_flange ? X_BF_ : X_[static_cast<std::size_t>(parts_[i].link)]) * parts_[i].capsule;
  }
}

/// Calls seen(fault, spare_mm) for whatever might be touched, until it answers that it has seen enough.
template <typename Seen>
void PoseChecker::look_about(Seen seen) {
  const Surroundings& about = scene_.surroundings;
  const int joints = scene_.robot.joint_count();
  const auto enough = [&](PoseFault fault, double distance_mm) {
    return seen(fault, distance_mm - about.clearance_mm);
  };
  for (const SightedReflector& reflector : reflectors_)
    if (enough(PoseFault::Floor, (X_BF_ * reflector.p_FS_mm).z() - about.floor_mm)) return;
  place_parts();
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    // What stands on the base is there in every pose, and link 1 turns on it.
    if (parts_[i].link < 2) continue;
    if (enough(PoseFault::Floor, lowest_mm(placed_[i]) - about.floor_mm)) return;
    if (enough(PoseFault::Tracker, distance_mm(placed_[i], tracker_))) return;
    for (const Capsule& obstacle : about.obstacles) {
      if (enough(PoseFault::Obstacle, distance_mm(placed_[i], obstacle))) return;
    }
    if (scene_.body.empty()) continue;  // joint centres have no extent that could collide
    for (std::size_t k = 0; k < i; ++k) {
      if (may_collide(parts_[k], parts_[i], joints) &&
          enough(PoseFault::ItselfCollides, distance_mm(placed_[k], placed_[i]))) {
        return;
      }
    }
  }
}

std::optional<PoseFault> PoseChecker::collision() {
  std::optional<PoseFault> found;
  look_about([&](PoseFault fault, double spare_mm) {
    if (spare_mm < 0) found = fault;
    return found.has_value();
  });
  return found;
}

bool PoseChecker::beam_cut(const Eigen::Vector3d& p_BS_mm) const {
  const Capsule beam{p_BT_mm_, p_BS_mm, 0};
  const auto cuts = [&](const Capsule& body) {
    return distance_mm(beam, body) < scene_.sight.beam_radius_mm;
  };
  for (std::size_t i = 0; i < placed_.size(); ++i) {
    // Beside the reflector's own mount the beam passes as near as the reflector sits on it.
    const bool mount = parts_[i].link >= scene_.robot.joint_count();
    if (mount ? distance_mm(beam, placed_[i]) < 0 : cuts(placed_[i])) return true;
  }
  return std::ranges::any_of(scene_.surroundings.obstacles, cuts);
}

JointVector approach_start(const RobotModel& robot, const JointVector& q, double way_rad) {
  JointVector start = q;
  for (int i = 0; i < robot.joint_count(); ++i) {
    const bool revolute = robot.joints[static_cast<std::size_t>(i)].type == JointType::Revolute;
    start[i] -= revolute ? way_rad : 1000 * way_rad;
  }
  return start;
}

std::optional<std::string> scene_mistake(const Scene& scene) {
  for (std::size_t i = 0; i < scene.robot.joints.size(); ++i) {
    const Joint& joint = scene.robot.joints[i];
    if (joint.min + margin_of(joint, scene) >= joint.max - margin_of(joint, scene)) {
      return "joint " + std::to_string(i + 1) +
             ": nothing is left between its limits once the margin is kept; make the margin smaller";
    }
  }
  if (const double off_mm = reflector_off_axis_mm(scene); scene.shows_last_axis && off_mm < kOffAxis_mm) {
    return formatted(
        "the reflector is %.1f mm from the last axis and would hardly show its rotation; mount it at "
        "least %.0f mm off",
        off_mm, kOffAxis_mm);
  }
  for (const BodyPart& part : scene.body) {
    if (part.link <= scene.robot.joint_count()) continue;
    for (const SightedReflector& reflector : reflectors_of(scene.sight)) {
      if (distance_mm(part.capsule, {reflector.p_FS_mm, reflector.p_FS_mm, 0}) >= 0) continue;
      return "the reflector lies inside the tool's body: make the body smaller or check the reflector's "
             "offset";
    }
  }
  return std::nullopt;
}

}  // namespace truepose
