#include "core/math/lbfgs.hpp"

#include <deque>
#include <ranges>
#include <vector>

#include "core/math/line_search.hpp"
#include "core/step_count.hpp"

namespace truepose {
namespace {

constexpr std::size_t kMemory = 8;

struct Correction {
  Eigen::VectorXd step, gradient_change;
  double curvature = 0;  ///< their product, > 0
};

/// Inverse Hessian, as the corrections know it, times the gradient: the two-loop recursion.
Eigen::VectorXd newton_like(const std::deque<Correction>& corrections, Eigen::VectorXd gradient) {
  // The first step: a unit long at most, for nothing is known of the scale yet.
  if (corrections.empty()) return gradient / std::max(1.0, gradient.norm());
  std::vector<double> alphas;
  for (const Correction& c : corrections | std::views::reverse) {
    alphas.push_back(c.step.dot(gradient) / c.curvature);
    gradient -= alphas.back() * c.gradient_change;
  }
  const Correction& last = corrections.back();
  gradient *= last.curvature / last.gradient_change.squaredNorm();
  for (const Correction& c : corrections) {
    gradient += (alphas.back() - c.gradient_change.dot(gradient) / c.curvature) * c.step;
    alphas.pop_back();
  }
  return gradient;
}

}  // namespace

Minimum minimise(const Objective& objective, const Eigen::VectorXd& start, const LbfgsOptions& options) {
  Minimum best{start};
  Eigen::VectorXd gradient(start.size());
  best.value = objective(start, gradient);
  std::deque<Correction> corrections;
  for (int i = 0; i < options.max_iterations; ++i) {
    const Eigen::VectorXd direction = -newton_like(corrections, gradient);
    Eigen::VectorXd trial_gradient(start.size());
    double trial_value = best.value;
    const auto along = [&](double step) {
      count_step();  // each: among many points one takes seconds
      trial_value = objective(best.x + step * direction, trial_gradient);
      return LinePoint{trial_value, trial_gradient.dot(direction)};
    };
    // The line search ends with the step that it evaluated last.
    const auto step =
        strong_wolfe_step(along, {best.value, gradient.dot(direction)}, {.max_evaluations = 20});
    if (!step) break;
    const Correction correction{*step * direction, trial_gradient - gradient, 0};
    const double gain = best.value - trial_value;
    best = {best.x + correction.step, trial_value};
    gradient = trial_gradient;
    if (gain < options.tolerance) break;
    corrections.push_back(correction);
    corrections.back().curvature = correction.step.dot(correction.gradient_change);
    if (corrections.size() > kMemory) corrections.pop_front();
  }
  return best;
}

}  // namespace truepose
