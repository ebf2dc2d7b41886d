#pragma once

#include <vector>

#include "tools/experiment/experiment.hpp"

namespace truepose {

/// Every layer of the model and of the compensation, at fresh targets: on a heavy arm with compliance and
/// gear harmonics, with each of the backlashes and numbers of poses, and on a rigid one with the fewest.
std::vector<LayerResult> compare_layers(const RobotModel& nominal, const ExperimentOptions& options,
                                        const ExperimentHooks& hooks);

}  // namespace truepose
