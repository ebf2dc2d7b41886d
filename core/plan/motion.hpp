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

  /// Whether the arm stays clear between two places. From a place at which it is not clear itself it may
  /// leave, and it may come to such a place, on a way that comes no nearer to anything than that place is.
  bool clear(const JointVector& from, const JointVector& to);

  /// Places to go by on the way: none where the motion itself is clear, else those of one or two stopovers.
  ///
  /// @param stopovers  places to choose from; those at which the arm is not clear are not regarded
  /// @return nothing where no way was found
  std::optional<std::vector<JointVector>> way(const JointVector& from, const JointVector& to,
                                              std::span<const JointVector> stopovers);

 private:
  /// The part of the way (0 to 1) after which the arm is clear; nothing where it comes nearer to anything
  /// before than it is at the start, or is never clear.
  std::optional<double> first_clear(const JointVector& from, const JointVector& to);

  PoseChecker checker_;
  double step_rad_;  // of the joint that moves most, from one place that is judged to the next
};

}  // namespace truepose
