#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/arm/forward.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose {

/// All points within a radius of a segment: the shape by which bodies are kept apart. mm.
struct Capsule {
  Eigen::Vector3d from_mm{0, 0, 0};
  Eigen::Vector3d to_mm{0, 0, 0};
  double radius_mm = 0;
};

/// The capsule, moved with the frame in which it stands.
inline Capsule operator*(const Eigen::Isometry3d& X, const Capsule& capsule) {
  return {X * capsule.from_mm, X * capsule.to_mm, capsule.radius_mm};
}

/// Distance between the surfaces of two capsules; negative where they overlap: the depth. Either may be a
/// sphere, and with a radius of 0 a segment or a point.
/// Source: Ericson, Real-Time Collision Detection (2005), section 5.1.9.
double distance_mm(const Capsule& a, const Capsule& b);

/// A part of what an arm occupies. It moves with link frame `link`: 0 the base, 1 to N the links, N + 1 the
/// flange, with whatever is mounted on it.
struct BodyPart {
  int link = 0;
  Capsule capsule;  ///< in that frame
};

/// A box, its edges along the axes of the robot base.
struct Box {
  Eigen::Vector3d min_mm{Eigen::Vector3d::Constant(-1e6)};
  Eigen::Vector3d max_mm{Eigen::Vector3d::Constant(1e6)};

  bool holds(const Eigen::Vector3d& p_mm) const {
    return (p_mm.array() >= min_mm.array()).all() && (p_mm.array() <= max_mm.array()).all();
  }
  /// Whether it is narrower than any cell.
  bool is_bounded() const {
    const Box any;
    return (min_mm.array() > any.min_mm.array()).any() || (max_mm.array() < any.max_mm.array()).any();
  }
};

/// A reflector on the flange, and how it can be seen. mm, rad.
struct SightedReflector {
  Eigen::Vector3d p_FS_mm{0, 0, 0};
  Eigen::Vector3d facing_F{0, 0, 1};  ///< direction of its opening, of any length
  double acceptance_rad = 0;          ///< half angle of the cone in which it can be seen
};

/// How the tracker sees the reflector on the flange; rough values do. mm, rad.
struct LineOfSight {
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::Vector3d p_FS_mm{0, 0, 0};
  Eigen::Vector3d facing_F{0, 0, 1};  ///< direction of the reflector's opening, of any length
  double acceptance_rad = 0;          ///< half angle of the cone in which the reflector can be seen
  double beam_radius_mm = 25;         ///< kept free around the beam: the placement is known roughly only
  std::vector<SightedReflector>
      further{};  ///< in addition to that one: a pose can be measured where one is seen
};

/// What stands about the arm. mm, in the robot base frame.
struct Surroundings {
  double floor_mm = 0;       ///< height of the floor
  double clearance_mm = 50;  ///< kept between the arm and all else, itself included
  std::vector<Capsule> obstacles;
  double tracker_radius_mm = 300;  ///< of the tracker and its stand, a post from the floor up
};

/// Everything by which a pose is judged before it is driven to.
struct Scene {
  RobotModel robot;  ///< the nominal arm
  std::vector<BodyPart>
      body;  ///< of the arm and its tool; empty: not known, and only joint centres are kept clear
  LineOfSight sight;
  Surroundings surroundings;
  Box workspace;                ///< in which the reflector stays
  double limit_margin_rad = 0;  ///< kept from the limits of revolute joints
  double limit_margin_mm = 10;  ///< kept from the limits of prismatic joints
  double wrist_margin_rad =
      0;  ///< least angle between the lines of axes N-2 and N, which singular wrists align
  /// Ways by which every joint comes to a pose (rad; prismatic: as many metres), positive from below. Each
  /// start of such a way must be clear too.
  std::vector<double> approach_rad;
  /// The reflector is to show how the last axis turns, and so must be off it.
  bool shows_last_axis = true;
};

/// Why a pose cannot be measured.
enum class PoseFault {
  JointLimit,
  OutsideWorkspace,
  TurnedAway,  ///< the reflector does not face the tracker
  SingularWrist,
  Floor,
  Obstacle,
  Tracker,  ///< the arm would touch the tracker
  ItselfCollides,
  BeamCut,  ///< the arm or an obstacle is between tracker and reflector
};
inline constexpr std::size_t kPoseFaults = 9;

/// What became of a pose with this fault: "came below the floor".
std::string_view fault_text(PoseFault fault);

/// Whether the tracker must see a reflector, or the arm is only to be driven there.
enum class Visibility { Required, Regardless };

/// Judges poses of one scene. Not for several threads at once.
class PoseChecker {
 public:
  explicit PoseChecker(Scene scene);

  /// What is wrong with q; nothing: it can be driven to and measured. What is cheap is judged first.
  std::optional<PoseFault> fault_of(const JointVector& q, Visibility visibility = Visibility::Required);

  /// What the arm touches at q: the part of fault_of() that matters on the way.
  std::optional<PoseFault> collision_at(const JointVector& q);

  /// How much farther than it must the arm is from touching anything at q, mm; negative where collision_at()
  /// finds a fault.
  double spare_mm(const JointVector& q);

  /// Bounds what a motion of all joints in step changes of spare_mm().
  ///
  /// @param way  of each joint, rad or mm
  double largest_change_mm(const JointVector& way) const;

  /// The reflectors that the tracker sees at q: 0 the first, then the further ones.
  std::vector<int> seen_at(const JointVector& q);

  const Scene& scene() const { return scene_; }

 private:
  bool within_margins(const JointVector& q) const;
  bool wrist_singular() const;
  bool faces(const SightedReflector& reflector) const;
  bool sees(const SightedReflector& reflector) const;
  void place(const JointVector& q);
  void place_parts();
  std::optional<PoseFault> approach_fault(const JointVector& q);
  std::optional<PoseFault> collision();
  template <typename Seen>
  void look_about(Seen seen);
  bool beam_cut(const Eigen::Vector3d& p_BS_mm) const;

  Scene scene_;
  std::vector<SightedReflector> reflectors_;  // all of the scene's, their directions normalised
  std::vector<BodyPart> parts_;               // the body, or joint centres where it is not known
  Eigen::Vector3d p_BT_mm_;                   // the tracker in the base frame
  Capsule tracker_;
  LinkFrames X_;  // of the links at the pose in hand
  Eigen::Isometry3d X_BF_;
  std::vector<Capsule> placed_;  // parts_ at the pose in hand
  JointVector lever_;            // how far each joint of the chain moves any point at most, mm per rad or mm
};

/// Where the arm starts for q, all joints by `way_rad` lower (prismatic: as many metres).
JointVector approach_start(const RobotModel& robot, const JointVector& q, double way_rad);

/// What makes the scene itself unfit for measuring: one sentence, or nothing. A reflector on the last axis,
/// which makes the last joint not identifiable, or one inside the tool's body; joints without room.
std::optional<std::string> scene_mistake(const Scene& scene);

}  // namespace truepose
