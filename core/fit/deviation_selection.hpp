#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/fit/deviation_groups.hpp"
#include "core/fit/least_squares_problem.hpp"
#include "core/fit/variance_components.hpp"

namespace truepose {

/// What one group bought.
struct DeviationGain {
  std::string name;
  bool chosen = false;
  double rms_mm = 0;  ///< cross-validated error of all groups but this one
};

struct DeviationChoice {
  std::vector<DeviationTerm> terms;  ///< coefficients 0; empty: geometry alone predicts best
  VarianceComponents likely;         ///< noise and widths with these terms
  double scale = 0;                  ///< the greatest prior standard deviation of a coefficient
  double geometric_rms_mm = 0;       ///< cross-validated error without any term, whitened
  double rms_mm = 0;                 ///< and with the terms
  std::vector<DeviationGain> gains;  ///< of every group
};

/// All groups or none: all where they lower the error at poses that the fit has not seen beyond what chance
/// gives (cross-validation; all points of a pose are left out together), about the geometric solution, in
/// which the problem is linear.
///
/// Each coefficient is as far from 0 as the evidence has those of its cause, but not further than gears err.
/// So terms that the robot does not have stay small, and what the fit says of its uncertainty holds for those
/// that no data tell: a choice among them would pretend to know.
/// @param geometric  cell at the solution without deviations
/// @param problem    that it solves
/// @param jobs       threads; the result is the same with any number
DeviationChoice choose_deviation(const CalibratedCell& geometric, const LeastSquaresProblem& problem,
                                 std::span<const DeviationGroup> groups, const ScaleExpectation& expected,
                                 int jobs = 1);

}  // namespace truepose
