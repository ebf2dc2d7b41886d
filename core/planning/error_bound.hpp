#pragma once

#include "core/planning/design.hpp"

namespace truepose {

/// What no choice of `poses` candidates goes below, and so how much any other choice than an optimal_design()
/// could still gain. Each of the two figures has a bound of its own. It holds always, and is as a rule within
/// a hundredth of what candidates measured in part reach; whole ones may stay further above.
///
/// The mean variance is a convex function of the parts (0 to 1) in which the candidates are measured, so that
/// each of its tangents bounds it from below; the worst one is bounded by a mean in which the badly predicted
/// positions weigh more.
///
/// @param poses  at least 1, at most as many as there are candidates
/// Source: Pukelsheim, Optimal Design of Experiments (1993), ch. 7; the parts after Silvey, Titterington,
/// Torsney, An algorithm for optimal designs on a finite design space (1978).
PredictedError error_bound(const DesignProblem& problem, int poses);

}  // namespace truepose
