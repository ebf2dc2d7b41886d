#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/plan/scene.hpp"

namespace truepose {

/// Judges point-to-point motions, in which all joints move in step. Not for several threads at once.
class MotionChecker {
 public:
  explicit MotionChecker(Scene scene);

  /// Whether the arm stays clear between two places. Places near an end at which it is not clear itself do
  /// not count: it stands there, and must be able to leave.
  bool clear(const JointVector& from, const JointVector& to);

  /// Places to go by on the way: none where the motion itself is clear, else those of one or two stopovers.
  ///
  /// @param stopovers  places to choose from; those at which the arm is not clear are not regarded
  /// @return nothing where no way was found
  std::optional<std::vector<JointVector>> way(const JointVector& from, const JointVector& to,
                                              std::span<const JointVector> stopovers);

 private:
  PoseChecker checker_;
  double step_rad_;  // of the joint that moves most, from one place that is judged to the next
};

}  // namespace truepose
