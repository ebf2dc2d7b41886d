#pragma once

#include <chrono>

#include "core/arm/robot_model.hpp"

namespace truepose {

using Seconds = std::chrono::duration<double>;

/// A synchronous point-to-point motion: all joints start and end together, with a trapezoidal speed profile
/// that the slowest joint dictates.
class JointMotion {
 public:
  /// @param speed_scale  of the joints' greatest speeds, above 0 (1 = full speed)
  /// @param ramp         time from standstill to that speed
  JointMotion(const RobotModel& robot, JointVector from, JointVector to, double speed_scale,
              Seconds ramp = Seconds{0.5});

  /// Position at a time after the start; `from` before it, exactly `to` from duration() on.
  JointVector position(Seconds t) const;
  Seconds duration() const { return duration_; }
  const JointVector& target() const { return to_; }

 private:
  double travelled(Seconds t) const;

  JointVector from_, to_;
  double speed_ = 0;  // of the travelled share s in [0, 1], per second
  Seconds ramp_{0};   // shortened where the motion is too short to reach full speed
  Seconds duration_{0};
};

}  // namespace truepose
