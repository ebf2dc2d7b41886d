#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/arm/robot_model.hpp"
#include "core/arm/status_turn.hpp"
#include "core/simulate/joint_motion.hpp"
#include "tools/sim/krl/host.hpp"

namespace truepose::sim {

/// Whether an arm has moved from one to the other.
bool differ(const JointVector& a, const JointVector& b);

/// The set points of a robot program's motions, cycle by cycle: PTP with all axes together, LIN and CIRC
/// along the path of the TCP in the base, its orientation turned about one axis, each with a trapezoid of
/// speed.
///
/// Approximated motions are made exactly: the arm stands at every point. Braking, going on and the override
/// change how fast time passes on the path, within kBraking.
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
  /// When something changes that is seen from outside; none while the arm stands.
  std::optional<Seconds> until_change(Seconds cycle) const;
  const JointVector& position() const { return q_; }
  const StatusTurnInverse& inverse() const { return *inverse_; }
  /// How many motions were made to their end.
  std::uint64_t made() const { return made_; }
  /// How many of them moved the arm.
  std::uint64_t moved() const { return moved_; }

 private:
  /// Joints at a time since its beginning, exactly the target from its duration on; none where the path
  /// leaves what the arm can reach.
  using Path = std::function<std::optional<JointVector>(Seconds)>;
  struct Making {
    std::uint64_t number = 0;
    Seconds duration{0};
    Path path;
    JointVector target;
    bool is_of_axes = true;  ///< its path is known at any time, whatever came before
    bool moves_arm = true;
  };

  ProgramMotion(RobotModel nominal, std::shared_ptr<const StatusTurnInverse> inverse, const JointVector& q)
      : nominal_{std::move(nominal)}, inverse_{std::move(inverse)}, q_{q}, end_{q} {}

  std::expected<JointVector, std::string> joints_of(const krl::Motion& motion) const;
  std::expected<JointVector, std::string> joints_at(const krl::PoseTarget& target,
                                                    const krl::Motion& motion) const;
  Eigen::Isometry3d tcp_of(const krl::PoseTarget& target, const krl::Motion& motion) const;
  Making along_axes(const krl::Motion& motion, const JointVector& target) const;
  Making along_path(const krl::Motion& motion, const JointVector& target) const;

  RobotModel nominal_;
  std::shared_ptr<const StatusTurnInverse> inverse_;
  JointVector q_;    ///< now
  JointVector end_;  ///< of the last motion that was taken
  std::deque<Making> waiting_;
  Seconds since_{0};  ///< the beginning of the first of them
  double rate_ = 1;   ///< at which time passes on the path, 0..1
  double override_ = 1;
  bool braked_ = false;
  std::uint64_t made_ = 0, moved_ = 0;
};

}  // namespace truepose::sim
