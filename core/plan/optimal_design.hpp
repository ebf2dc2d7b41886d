#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/plan/design.hpp"

namespace truepose {

struct DesignOptions {
  DesignCriterion criterion = DesignCriterion::I;
  int poses = 30;
  int restarts = 3;        ///< random designs that the exchange starts from, in addition to the greedy one
  int max_passes = 50;     ///< over the chosen poses; each pass improves the design or is the last
  std::uint64_t seed = 0;  ///< of the random designs
};

/// The candidate that serves a design's criterion best of those that it does not have and that are allowed.
/// None where none is.
///
/// @param allowed  one flag a candidate; empty = every one
std::optional<std::size_t> best_addition(Design& design, const std::vector<bool>& allowed = {});

/// Adds to a design, one by one, the candidate that serves its criterion best, until it has `poses`.
void add_greedily(Design& design, int poses);

/// The candidates to measure: greedily chosen ones and random ones, each bettered by exchange, in which every
/// chosen pose in turn is given up for the candidate that serves the criterion best, until none can be
/// bettered; the best of them. Local optima, so that more restarts may find a better one.
///
/// @param options.poses  at most as many as there are candidates
/// @return indices of the chosen candidates, ascending
/// Source: Fedorov, Theory of Optimal Experiments (1972), ch. 3.
std::vector<std::size_t> optimal_design(const DesignProblem& problem, const DesignOptions& options);

/// What designs of a size lead to.
struct DesignSize {
  int poses = 0;
  PredictedError error;
};

/// Optimal designs of several sizes: how the predicted error falls with the number of poses.
std::vector<DesignSize> design_sizes(const DesignProblem& problem, const DesignOptions& options,
                                     std::span<const int> sizes);

/// The smallest size from which twice as many poses would lower the error of a compensated arm, its
/// repeatability included, by less than `gain`; none where all sizes are too small.
///
/// @param sizes             ascending; the error of others is taken to fall as 1 / sqrt(poses)
/// @param repeatability_mm  standard deviation per axis of the arm's position
std::optional<int> enough_poses(std::span<const DesignSize> sizes, double repeatability_mm,
                                double gain = 0.05);

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
