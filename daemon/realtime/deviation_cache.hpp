#pragma once

#include <optional>

#include "core/compensate/target_compensation.hpp"
#include "core/math/units.hpp"

namespace truepose::daemon {

/// The compensation of an arm in motion. What its model has beyond the geometry costs ten times as much as
/// the geometry, and hardly changes on the way of a cycle: it is looked at after the reply, where the arm is
/// expected next, and is taken as constant around there. The realtime thread's own; does not allocate.
class DeviationCache {
 public:
  /// Farther from where it was computed, a joint's deviation is computed again: an arm that brakes by 300
  /// deg/s^2 is so far from where it was expected after 4 ms. Gears of 2e-4 rad in the second order, and a
  /// field that changes by 0.3 mm in a radian, change by 4e-8 rad and 0.03 um on that way: the last digit of
  /// the wire.
  static constexpr double kNear_rad = 0.005 * kRadPerDeg;

  /// Another model, session or place, or another side that a joint is come to from: nothing is expected.
  void restart() noexcept { *this = {}; }
  /// As TargetCompensation::at_joints_within().
  TargetCompensation::Result at_joints_within(int steps, const TargetCompensation& compensation,
                                              const JointVector& commanded, const Eigen::Vector3d& p_F_mm,
                                              JointVector& correction) noexcept;
  /// After the reply.
  void look_ahead(const TargetCompensation& compensation) noexcept;

 private:
  std::optional<NonGeometricError> ahead_;
  std::optional<JointVector> now_, before_;  // joints that the last two replies led to
};

}  // namespace truepose::daemon
