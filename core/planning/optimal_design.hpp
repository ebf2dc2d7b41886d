#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/calibration/calibrated_cell.hpp"

namespace truepose {

enum class DesignCriterion {
  D,  ///< the smallest volume of the parameters' uncertainty
  I,  ///< the smallest mean variance of the predicted positions of the task
};

struct DesignOptions {
  DesignCriterion criterion = DesignCriterion::I;
  int poses = 30;          ///< more than identify the cell: 9 poses of one reflector give 27 parameters
  int max_passes = 50;     ///< over the chosen poses; each pass improves the design or is the last
  std::uint64_t seed = 0;  ///< of the design from which the exchange starts
};

/// Chooses the candidates to measure, by exchange: each chosen pose in turn is given up for the candidate
/// that serves the criterion best, until none can be bettered. The result is a local optimum.
///
/// @param cell        roughly known, for the Jacobian alone
/// @param candidates  at least `options.poses`; no candidate is chosen twice
/// @param task        poses at which the predictions matter (criterion I)
/// @return indices of the chosen candidates, ascending
/// Source: Fedorov, Theory of Optimal Experiments (1972), ch. 3.
std::vector<std::size_t> optimal_design(const CalibratedCell& cell, std::span<const JointVector> candidates,
                                        std::span<const JointVector> task, const DesignOptions& options);

}  // namespace truepose
