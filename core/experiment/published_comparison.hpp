#pragma once

#include <span>
#include <vector>

#include "core/experiment/experiment.hpp"

namespace truepose {

/// What a fit must do wrong to come to the paper's two simulated figures, and what it reaches otherwise.
///
/// The paper does not say from which region it draws its points, and both errors grow with it; here the
/// middle 40 % of each joint's range, where both come out near the printed ones.
std::vector<PublishedComparison> explain_published(const RobotModel& nominal,
                                                   const ExperimentOptions& options,
                                                   const ExperimentHooks& hooks);

/// The paper's figures of its real arm beside the heavy arm's with the fewest poses. Two different arms: this
/// shows magnitudes, and reproduces nothing.
std::vector<PublishedComparison> beside_the_real_arm(std::span<const LayerResult> layers);

}  // namespace truepose
