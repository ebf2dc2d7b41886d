#pragma once

#include <span>
#include <vector>

#include "tools/experiment/experiment.hpp"

namespace truepose {

/// Random poses (new ones in each trial) against the D- and the I-optimal choice from the same candidates,
/// judged by two-stage fits to noisy readings.
std::vector<DesignResult> compare_designs(const RobotModel& nominal, const ExperimentOptions& options,
                                          const ExperimentHooks& hooks);

/// Every layer of the model and of the compensation, at fresh targets: on a heavy arm with compliance and
/// gear harmonics, with each of the backlashes and numbers of poses, and on a rigid one with the fewest.
std::vector<LayerResult> compare_layers(const RobotModel& nominal, const ExperimentOptions& options,
                                        const ExperimentHooks& hooks);

struct MethodComparison {
  double bound_rms_mm = 0;
  std::vector<MethodResult> methods;
};

/// Every method on the same trials.
MethodComparison compare_methods(const RobotModel& nominal, const ExperimentOptions& options,
                                 const ExperimentHooks& hooks);

/// What the method's paper prints of its results, mm. Source: Liu, Yang, Zhang, Shi, Li, Li, Method for
/// improving robot positioning accuracy based on two-stage iterative compensation, doi
/// 10.7690/bgzdh.2026.05.019.
namespace published {

/// Mean position error of the simulated arm, 30 + 30 random points (section 3.1).
inline constexpr double kSimulatedLeastSquares_mm = 0.2951;
inline constexpr double kSimulatedTwoStage_mm = 0.1681;

/// Position errors of the real KR 210 R2700, 30 validation points (Table 4).
struct Stage {
  double max_mm, min_mm, mean_mm;
};
inline constexpr Stage kRealBefore{4.465, 1.139, 2.862};
inline constexpr Stage kRealGeometric{0.803, 0.533, 0.693};
inline constexpr Stage kRealResidual{0.756, 0.410, 0.571};

}  // namespace published

/// What a fit must do wrong to come to the paper's two simulated figures, and what it reaches otherwise.
///
/// The paper does not say from which region it draws its points, and both errors grow with it; here the
/// middle 40 % of each joint's range, where both come out near the printed ones.
std::vector<PublishedComparison> explain_published(const RobotModel& nominal,
                                                   const ExperimentOptions& options,
                                                   const ExperimentHooks& hooks);

/// The paper's figures of its real arm compared with the heavy arm's with the fewest poses. The arms differ:
/// this shows magnitudes, and reproduces nothing.
std::vector<PublishedComparison> compared_with_real_arm(std::span<const LayerResult> layers);

}  // namespace truepose
