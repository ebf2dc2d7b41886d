#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <expected>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/arm/robot_model.hpp"
#include "core/arm/status_turn.hpp"
#include "tools/sim/krl/host.hpp"
#include "tools/sim/motion/speed_profile.hpp"
#include "tools/sim/motion/tcp_path.hpp"

namespace truepose::sim {

/// Whether an arm has moved from one to the other.
bool differ(const JointVector& a, const JointVector& b);

/// Where a motion switches something.
struct PlannedSwitch {
  enum class Anchor { Start, End, Inside };
  std::uint64_t number = 0;
  Anchor anchor = Anchor::End;
  Seconds inside{0};   ///< of the anchor inside: since the motion's beginning
  double path_mm = 0;  ///< from the anchor along the path
  Seconds delay{0};    ///< below 0: so long before
};

/// What a motion of a program is for the arm.
struct PlannedMotion {
  /// Joints at a time since its beginning, exactly the target from its duration on; none where the path
  /// leaves what the arm can reach.
  using Path = std::function<std::optional<JointVector>(Seconds)>;
  std::uint64_t number = 0;
  Seconds duration{0};
  Path path;
  JointVector target;
  std::optional<SpeedProfile> along = {};  ///< of the TCP's path; none where the axes go their own
  Seconds blended{0};  ///< before its end, when the next may begin; 0 where it is not approximated
  bool moves_arm = true;
  std::vector<PlannedSwitch> switches = {};
};

/// Plans the motions of robot programs: PTP with all axes together, LIN and CIRC along the path of the TCP in
/// the base, its orientation turned about one axis, each with a trapezoid of speed; spline blocks through all
/// their points, with a stop where lines and arcs meet in a corner.
///
/// CIRC with CA: the circle through the three points, the angle of it, and the orientation that was
/// programmed at its end. What else KUKA's own planner decides, such as how a spline bends between its
/// points, is not known here and simple.
class MotionPlanner {
 public:
  /// @param nominal  six axes with a spherical wrist, as the controller has them
  /// @return the planner, or one sentence on why this arm cannot be moved along a path
  static std::expected<MotionPlanner, std::string> of(const RobotModel& nominal);

  /// @param from  where the motion before ends
  /// @return why it cannot be made: out of reach, or not simulated
  std::expected<PlannedMotion, std::string> plan(const krl::Motion& motion, const JointVector& from) const;
  const StatusTurnInverse& inverse() const { return *inverse_; }

 private:
  MotionPlanner(RobotModel nominal, std::shared_ptr<const StatusTurnInverse> inverse)
      : nominal_{std::move(nominal)}, inverse_{std::move(inverse)} {}

  /// The TCP's path and how fast it is gone along.
  struct Course {
    std::vector<TcpPath> pieces;
    std::vector<SpeedLimit> limits;
  };
  std::expected<PlannedMotion, std::string> along_axes(const krl::Motion& motion,
                                                       const JointVector& from) const;
  std::expected<PlannedMotion, std::string> through_axes(const krl::Motion& block,
                                                         const JointVector& from) const;
  std::expected<PlannedMotion, std::string> along_path(const krl::Motion& motion,
                                                       const JointVector& from) const;
  std::expected<Course, std::string> course_of(const krl::Motion& motion, const JointVector& from) const;
  std::expected<JointVector, std::string> joints_of(const krl::Motion& motion, const JointVector& from) const;
  Eigen::Isometry3d tcp(const krl::Motion& motion, const JointVector& q) const;

  RobotModel nominal_;
  std::shared_ptr<const StatusTurnInverse> inverse_;
};

}  // namespace truepose::sim
