#pragma once

#include <bitset>
#include <optional>

#include "core/arm/forward.hpp"

namespace truepose {

/// What the joints have to bring about to first order, the position before all else. In units in which
/// lengths and angles compare (lengths over kLength_mm).
struct PositionTask {
  JointJacobian J;          ///< of the point, rows as in forward_with_jacobian()
  Eigen::Vector3d p_error;  ///< target less actual
};

inline constexpr double kLength_mm = 1000;  ///< counts as 1 rad

/// Steps near a wrist singularity: `others` takes the position's error away, and as much of the
/// orientation's as goes without turning axes 4 and 6 against each other; adding t times `opposite` turns
/// them by t and -t, the position kept.
struct WristStep {
  JointVector others, opposite;
  /// What is left of the orientation's error is (e - s t) in one direction.
  double e_squared = 0, s_squared = 0, e_s = 0;
};

/// @param opposite_sense  +1 where axes 4 and 6 turn against each other by opposite signs of q, else -1
/// @return nothing in another singularity of the arm
std::optional<WristStep> wrist_step(const PositionTask& task, const Eigen::Vector3d& rotation_error,
                                    double opposite_sense);

/// The step that takes the position's error away and is nearest to the step `wanted`.
///
/// @param held  joints that take their wanted step
/// @return nothing where the other joints cannot move the point in all directions
std::optional<JointVector> nearest_step(const PositionTask& task, const JointVector& wanted,
                                        const std::bitset<kMaxJoints>& held);

}  // namespace truepose
