#pragma once

#include <vector>

#include "tools/experiment/experiment.hpp"

namespace truepose {

/// Random poses (new ones in each trial) against the D- and the I-optimal choice from the same candidates,
/// judged by two-stage fits to noisy readings.
std::vector<DesignResult> compare_designs(const RobotModel& nominal, const ExperimentOptions& options,
                                          const ExperimentHooks& hooks);

}  // namespace truepose
