#pragma once

#include <expected>

#include "core/arm/joint_deviation.hpp"
#include "core/arm/robot_model.hpp"

namespace truepose {

class ArmKernel;

struct PoseInverseOptions {
  double position_tolerance_mm = 1e-9;
  double rotation_tolerance_rad = 1e-12;
  int max_iterations = 50;
  /// Weighs 1 rad of orientation, and of a revolute joint's step, against millimetres.
  double length_mm = 1000;
  /// Where no descent from the seed leads to X_BF (as across a singularity): so many searches follow by steps
  /// that need not descend, and may end on another branch than the seed's.
  int leaps = 0;
  Approach approach;  ///< directions in which the joints will have moved at X_BF, for arms with backlash
  /// Whether max_iterations are one part of a search: then they are counted over all of it, and where they
  /// led is the result, whose residuals tell how far that is from X_BF.
  bool in_parts = false;
};

enum class PoseInverseFault { DidNotConverge, NotFinite };

struct PoseInverseResult {
  JointVector q;
  double residual_mm = 0;
  double residual_rad = 0;
  int iterations = 0;
};

/// Encoder positions at which `robot` (usually a calibrated one, its deviations included) stands at X_BF:
/// Newton with the analytic Jacobian from `q_seed`, damped (Levenberg-Marquardt) only where a full step would
/// lead away. Stays on the seed's branch. With more than six joints the step is the smallest. Allocates for
/// a coupled arm alone. Joint limits are the caller's to judge.
std::expected<PoseInverseResult, PoseInverseFault> inverse_near(const RobotModel& robot,
                                                                const Eigen::Isometry3d& X_BF,
                                                                const JointVector& q_seed,
                                                                const PoseInverseOptions& options = {});

/// The same for an arm whose geometry is prepared. Does not allocate.
std::expected<PoseInverseResult, PoseInverseFault> inverse_near(const RobotModel& robot,
                                                                const ArmKernel& geometry,
                                                                const Eigen::Isometry3d& X_BF,
                                                                const JointVector& q_seed,
                                                                const PoseInverseOptions& options = {});

}  // namespace truepose
