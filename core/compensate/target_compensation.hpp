#pragma once

#include <expected>
#include <optional>
#include <string>

#include "core/arm/arm_kernel.hpp"
#include "core/arm/pose_inverse.hpp"
#include "core/arm/robot_model.hpp"
#include "core/math/angles.hpp"

namespace truepose {

/// Why a target is not reached.
struct CompensationFault {
  enum class Kind { DidNotConverge, NotFinite, BeyondLimit, TooFar, TooFewJoints };
  Kind kind = Kind::DidNotConverge;
  int joint = 0;         ///< BeyondLimit, TooFar: its index
  double q_wrong = 0;    ///< BeyondLimit: where it would have to go, rad or mm
  double too_large = 0;  ///< TooFar: the correction that it would need, rad or mm
};

/// "joint 4 would have to go to 352.1 deg, its limits are -350..350"
/// @param nominal  whose limits they are
std::string cause_of(const CompensationFault& fault, const RobotModel& nominal);
/// "move it away from there"
std::string way_out(CompensationFault::Kind kind);
/// Both, in one sentence.
std::string described(const CompensationFault& fault, const RobotModel& nominal);

struct CompensationOptions {
  /// Angle (rad) between axes 4 and 6 under which a correction may be damped; 0 = never.
  double singular_below = 20 * kRadPerDeg;
  /// To what (rad) it is damped there, see TargetCompensation; above 0.
  double singular_bound = 0.5 * kRadPerDeg;
  /// Greatest correction of a joint, rad (of a slide: as many metres). No arm is wrong by so much: beyond, a
  /// singularity asks for it.
  double largest_correction = 10 * kRadPerDeg;
  Approach approach;  ///< directions in which the joints will have moved, for arms with backlash
};

/// What an arm has beyond its geometry at joints q: deviations of its joints and the displacement of its
/// flange.
struct NonGeometricError {
  JointVector q;       ///< encoder positions
  JointVector turned;  ///< true joint positions less these
  Eigen::Isometry3d X_moved =
      Eigen::Isometry3d::Identity();  ///< from where the geometry puts the flange, base frame
};

struct CompensatedTarget {
  JointVector q;            ///< to command
  double residual_mm = 0;   ///< of the point
  double residual_rad = 0;  ///< of the orientation; 0 where none was asked for
  int iterations = 0;
  bool damped = false;  ///< orientation was given up so that axes 4 and 6 need not turn far
};

/// What to command so that a calibrated arm stands where it should, one target at a time: stage 2 of the
/// paper (eqs 27 to 30 with the signs corrected), bounded near the wrist singularity. A pure function of the
/// target, which only keeps prepared what it needs of the arms. Does not allocate.
///
/// Where axes 4 and 6 fall into line, a turn of the flange about the line that is square to them and to axis
/// 5 takes opposite turns u and -u of both: with s = 2 sin(A5 / 2) the flange turns by s u. An error e of
/// orientation about that line asks for u = e / s, without bound and with a change of sign at s = 0. All else
/// (position, the two other directions of orientation) is as well conditioned as elsewhere. So the joints
/// are those that put the point exactly into place and have, of these, the least
///
///   |error of orientation|^2 + lambda^2 u^2,   u the opposite part of the correction,
///
/// which to first order is u = s e / (s^2 + lambda^2): continuous, 0 at s = 0, and nowhere above
/// e / (2 lambda). With r = e / b, the s at which the exact u is b,
///
///   lambda = 0.55 r (1 - (s / s0)^2),   s0 = 2 r, but at most `singular_below`,
///
/// keeps |u| <= b for all s, and is exact where the exact u is below b / 2. (Where errors are so large that
/// s0 is cut off, |u| <= b + e / singular_below: not more than b beyond what the regular neighbours need.) b
/// is `singular_bound` less the turn that axes 4 and 6 have in common, so that their whole correction stays
/// within it, but at least a tenth of it. r^2 is taken 0.03^2 larger, or the result would change fast where e
/// goes through 0.
///
/// Lambda is set once, from the error at the nominal joints; Newton's steps on this least-squares problem,
/// each with the position as a constraint, then run to their fixed point. Because lambda depends continuously
/// on the target, so does the result: neighbours get neighbouring corrections. The rejected alternative,
/// cutting u off at b, jumps from b to -b at s = 0; another, scaling u after the fact, spoils the position.
///
/// Where the position can only be had by an orientation that is worse than without a correction, or would
/// leave a point within 300 mm of the flange worse (with a singularity of the arm near, or axes of the wrist
/// that do not meet), the correction is shortened until neither is: by the largest part that is no worse.
/// `residual_mm` is then what the position gives up. Of random targets this
/// needs one in fifty on KUKA's wrist and one in eighteen on a UR10 (errors up to 4 mrad an axis). The
/// rejected alternative, a weight on the position, gives up 30 to 45 % less of it for twice the code.
///
/// Holds for arms whose last three joints turn, of six joints or more; others are never damped.
///
/// In the arm's other singularities (wrist centre above axis 1, arm stretched) the position itself cannot be
/// corrected in one direction, and nothing that could be given up would help: where a joint's correction
/// would exceed `largest_correction` the target is refused.
class TargetCompensation {
 public:
  using Result = std::expected<CompensatedTarget, CompensationFault>;

  TargetCompensation(const RobotModel& nominal, const RobotModel& calibrated,
                     const CompensationOptions& options = {});

  // In all of these p_F (mm, flange frame) is the point whose position comes first: the TCP, where it is
  // known.

  /// The calibrated arm stands where the nominal one would at `q`.
  Result at_joints(const JointVector& q, const Eigen::Vector3d& p_F_mm = {0, 0, 0}) const;
  /// The same in at most so many of Newton's steps, for a target that moves little from call to call.
  /// DidNotConverge may say that they were too few: another call with the same `q` continues.
  /// @param correction  of q: where the search is, zero at first; and where it came to
  /// @param beyond      where given, joints deviate and the flange is displaced everywhere as at `beyond->q`:
  /// near
  ///                    there, much faster
  Result at_joints_within(int steps, const JointVector& q, const Eigen::Vector3d& p_F_mm,
                          JointVector& correction, const NonGeometricError* beyond = nullptr) const;
  NonGeometricError non_geometric_error(const JointVector& q) const;

  /// The flange is at X_BF.
  /// @param q_nominal  joints of the nominal arm there: the branch, and what the correction is counted from
  Result at_pose(const Eigen::Isometry3d& X_BF, const JointVector& q_nominal,
                 const Eigen::Vector3d& p_F_mm = {0, 0, 0}) const;
  /// The point is at p_B (mm, base frame), whatever the orientation, by the joints nearest to `q_near`: of
  /// the least sum of squares, 1 rad as 1 m. A joint that would go beyond its limit stays at it.
  Result at_position(const Eigen::Vector3d& p_B_mm, const JointVector& q_near,
                     const Eigen::Vector3d& p_F_mm = {0, 0, 0}) const;

 private:
  struct State;
  /// Where it is, and how many of Newton's steps it may take; none: as many as it needs.
  struct Search {
    JointVector q;
    std::optional<int> steps{};
    const NonGeometricError* beyond = nullptr;  ///< null where it is to be looked at in every step
  };
  State state_at(const JointVector& q, const Eigen::Vector3d& p_F_mm, const NonGeometricError* beyond) const;
  bool has_wrist() const;
  Result at_pose(const Eigen::Isometry3d& X_BF, const JointVector& q_nominal, const Eigen::Vector3d& p_F_mm,
                 Search& search) const;
  std::expected<PoseInverseResult, PoseInverseFault> inverse(const Eigen::Isometry3d& X_BF,
                                                             const Search& search,
                                                             const PoseInverseOptions& options) const;
  Result exact(const Eigen::Isometry3d& X_BF, const JointVector& q_nominal, Search& search) const;
  Result damped(const Eigen::Isometry3d& X_BF, const JointVector& q_nominal, const Eigen::Vector3d& p_F_mm,
                State state, Search& search) const;
  CompensatedTarget no_worse_than_none(const Eigen::Isometry3d& X_BF, const JointVector& q_nominal,
                                       const Eigen::Vector3d& p_F_mm, const NonGeometricError* beyond,
                                       CompensatedTarget target) const;
  Result near(const JointVector& q_nominal, const CompensatedTarget& target) const;
  Result within_limits(const CompensatedTarget& target) const;

  RobotModel nominal_, calibrated_;
  ArmKernel nominal_geometry_, geometry_;
  CompensationOptions options_;
};

}  // namespace truepose
