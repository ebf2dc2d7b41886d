#pragma once

#include <vector>

#include "tools/experiment/experiment.hpp"

namespace truepose {

struct MethodComparison {
  double bound_rms_mm = 0;
  std::vector<MethodResult> methods;
};

/// Every method on the same trials.
MethodComparison compare_methods(const RobotModel& nominal, const ExperimentOptions& options,
                                 const ExperimentHooks& hooks);

}  // namespace truepose
