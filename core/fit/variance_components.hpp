#pragma once

#include <optional>
#include <vector>

#include "core/fit/evidence.hpp"
#include "core/fit/least_squares_problem.hpp"
#include "core/fit/prior.hpp"

namespace truepose {

/// The class of a deviation term, and what a unit of that class' width means for its coefficient.
struct TermWidth {
  int of = 0;  ///< index of its class
  double unit = 1;
};

/// What is expected of a problem before its points are looked at.
struct ScaleExpectation {
  WidthExpectation noise;                    ///< of a whitened coordinate, mm
  PriorScale links;                          ///< usual widths
  std::vector<TermWidth> terms;              ///< of each deviation term
  std::vector<WidthExpectation> deviations;  ///< of each class of terms
};

/// Noise and widths under which measured points are most likely.
struct VarianceComponents {
  double sigma_mm = 0;              ///< noise of a whitened coordinate
  std::optional<PriorScale> links;  ///< where the problem has a prior of the links
  std::vector<double> term_widths;  ///< of each deviation term

  bool operator==(const VarianceComponents&) const = default;
};

/// Of the problem linearised at `cell`, in which base, reflectors and, where it has no prior of them, links
/// are unknown.
VarianceComponents most_likely_components(const CalibratedCell& cell, const LeastSquaresProblem& problem,
                                          const ScaleExpectation& expected);

/// What a tracker and an arm's repeatability usually add up to, or near `stated_mm` where that is not 0.
WidthExpectation expected_noise(double stated_mm);

/// The prior with these widths, links scattering about `centre`.
Prior prior_of(const CalibratedCell& cell, const Prior& links, const VarianceComponents& likely);

}  // namespace truepose
