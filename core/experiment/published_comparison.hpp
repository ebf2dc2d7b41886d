#pragma once

#include <vector>

#include "core/experiment/experiment.hpp"

namespace truepose {

/// What a fit must do wrong to come to the paper's two simulated figures, and what it reaches otherwise.
///
/// The paper does not say from which region it draws its points, and both errors grow with it; here the
/// middle 40 % of each joint's range, where both come out near the printed ones.
std::vector<PublishedComparison> explain_published(const RobotModel& nominal,
                                                   const ExperimentOptions& options);

}  // namespace truepose
