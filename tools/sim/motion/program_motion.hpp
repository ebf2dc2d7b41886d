#pragma once

#include <cstdint>
#include <deque>
#include <expected>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/sim/motion/motion_planner.hpp"
#include "tools/sim/motion/switching_points.hpp"

namespace truepose::sim {

/// The set points of a robot program's motions, cycle by cycle.
///
/// An approximated motion (C_PTP, C_DIS, C_SPL) is blended with the next where the advance run knows that in
/// time: the next begins before the end, at $APO.CDIS before the target or $APO.CPTP percent of the braking,
/// and both motions add up. Braking, going on and the override change how fast time passes on the path,
/// within kBraking.
class ProgramMotion {
 public:
  static constexpr Seconds kBraking{0.15};

  /// @param nominal  six axes with a spherical wrist, as the controller has them
  /// @return the motions, or one sentence on why this arm cannot be moved along a path
  static std::expected<ProgramMotion, std::string> of(const RobotModel& nominal, const JointVector& q);

  /// Takes a motion, to be made after those taken before.
  /// @param reduced  as in T1: a tenth of the axes' speed, 250 mm/s along a path
  /// @return why its target cannot be reached
  std::expected<void, std::string> take(krl::Motion motion, bool reduced = false);
  bool is_finished(std::uint64_t motion) const;
  /// The drives are off: a braked arm stands at once.
  void halt() {
    if (braked_) rate_ = 0;
  }
  bool is_standing() const { return waiting_.empty() || (braked_ && rate_ == 0); }
  void brake() { braked_ = true; }
  void go_on() { braked_ = false; }
  /// $OV_PRO, 0..1.
  void set_override(double share) { override_ = share; }
  /// Forgets all motions; the arm stands where it is.
  void cancel();
  /// The same, where something else has moved it to.
  void place(const JointVector& q);

  /// Moves on by one cycle. @return what the program commands
  const JointVector& advance(Seconds cycle);
  /// When something changes that is seen from outside; none while the arm stands and nothing is to be
  /// switched.
  std::optional<Seconds> until_change(Seconds cycle) const;
  /// The switching points that it came to since this was last asked, within a cycle.
  std::vector<std::uint64_t> take_switched() { return switching_.take(); }
  const JointVector& position() const { return q_; }
  const StatusTurnInverse& inverse() const { return planner_.inverse(); }
  /// Whether the arm is moved by its axes, not along a path: PTP and its like.
  bool is_ptp() const { return !is_standing() && !waiting_.front().along; }
  /// How many motions were made to their end.
  std::uint64_t made() const { return made_; }
  /// How many of them moved the arm.
  std::uint64_t moved() const { return moved_; }

 private:
  ProgramMotion(MotionPlanner planner, const JointVector& q) : planner_{std::move(planner)}, q_{q}, end_{q} {}

  Seconds blended_out() const;
  std::optional<Seconds> into_next() const;
  /// @param time  on the path
  void move_on(Seconds time);

  MotionPlanner planner_;
  JointVector q_;    ///< now
  JointVector end_;  ///< of the last motion that was taken
  std::deque<PlannedMotion> waiting_;
  SwitchingPoints switching_;
  Seconds since_{0};       ///< the beginning of the first of them
  Seconds blended_in_{0};  ///< of which it overlapped the one before
  double rate_ = 1;        ///< at which time passes on the path, 0..1
  double override_ = 1;
  bool braked_ = false;
  std::uint64_t made_ = 0, moved_ = 0;
};

}  // namespace truepose::sim
