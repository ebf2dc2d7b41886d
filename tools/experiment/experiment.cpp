#include "tools/experiment/experiment.hpp"

#include <algorithm>
#include <iterator>

#include "core/simulate/published_arm.hpp"
#include "tools/experiment/comparisons.hpp"

namespace truepose {

std::expected<ExperimentResult, std::string> run_experiment(const RobotModel& nominal,
                                                            const ExperimentOptions& options,
                                                            const ExperimentHooks& hooks) {
  const bool revolute =
      std::ranges::all_of(nominal.joints, [](const Joint& j) { return j.type == JointType::Revolute; });
  if (nominal.joints.size() != kPublishedErrors.size() || !revolute)
    return std::unexpected("the experiment needs an arm of six revolute joints, and '" + nominal.name +
                           "' is none");

  ExperimentResult result;
  MethodComparison methods = compare_methods(nominal, options, hooks);
  result.bound_rms_mm = methods.bound_rms_mm;
  result.methods = std::move(methods.methods);
  result.designs = compare_designs(nominal, options, hooks);
  result.layers = compare_layers(nominal, options, hooks);
  result.published = explain_published(nominal, options, hooks);
  std::ranges::move(compared_with_real_arm(result.layers), std::back_inserter(result.published));
  return result;
}

}  // namespace truepose
