#include <algorithm>
#include <cmath>

#include "core/calibrate/identification.hpp"
#include "core/fit/identifiability.hpp"
#include "core/fit/prior.hpp"
#include "core/fit/variance_components.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// The arm counts as not excited where the prediction elsewhere is so many times worse than one measurement.
constexpr double kPoorTransfer = 4;
constexpr int kWidthEstimates = 4;

/// Whether the points alone give more equations than parameters to fit.
bool determined(const Identification& id) { return id.points.equations() > id.result.rank; }

bool prior_wanted(const Identification& id) {
  if (id.options.prior == PriorUse::Off) return false;
  if (id.options.prior == PriorUse::On || !determined(id)) return true;
  // What acts through less than the noise wanders without an end: it keeps to the data sheet.
  if (!id.fit.converged) return true;
  return !(transfer_of(id.fit.cell, id.uncertainty.covariance).rms_mm <=
           kPoorTransfer * std::sqrt(3.0) * id.uncertainty.sigma0_mm);
}

/// Refits with the prior, whose widths and noise are those that the points make most likely.
/// @return as assess()
Eigen::MatrixXd use_prior(Identification& id) {
  CalibratedCell nominal = id.fit.cell;
  nominal.robot = id.nominal;
  id.problem.free = first_parameters(ParameterLayout::of(nominal).size());
  id.problem.prior = prior_of(nominal, id.options.prior_scale, 1);
  id.fit.cell = id.result.coarse;
  const ScaleExpectation expected{.noise = expected_noise(id.points.stated_sigma_mm()),
                                  .links = id.options.prior_scale};
  for (int i = 0; i < kWidthEstimates; ++i) {
    const TrustedProblem trusted = trusted_problem(id);
    const VarianceComponents likely = most_likely_components(id.fit.cell, trusted.problem, expected);
    id.problem.prior = prior_of(nominal, id.problem.prior, likely);
    id.fit = solve(id.fit.cell, id.problem, id.options.max_fine_iterations);
    id.result.fine_iterations += id.fit.iterations;
    id.result.prior_scale = *likely.links;
  }
  return assess(id);
}

/// What the poses can tell of the links, judged before they are fitted.
std::optional<CalibrationError> judge_poses(Identification& id) {
  const ParameterLayout layout = ParameterLayout::of(id.result.coarse);
  id.problem = id.points.problem(first_parameters(layout.size()));
  const Eigen::MatrixXd J = triangular_factor(linearise(id.result.coarse, id.problem).J);
  const Identifiability known = identifiability(J, conventional_preference(layout));
  id.result.rank = known.rank;
  id.result.rank_gap = known.gap;
  id.identified = known.kept;
  id.problem.free = known.kept;
  if (determined(id) || id.options.prior != PriorUse::Off) return std::nullopt;
  const int equations = id.points.equations();
  return CalibrationError{CalibrationFault::TooFewPoses,
                          std::to_string(equations / 3) + " points give " + std::to_string(equations) +
                              " equations for at least as many parameters: measure more poses"};
}

/// What the poses show of the fitted geometry, and what they leave open.
///
/// @param J  assess() of it
void describe_known(Identification& id, const Eigen::MatrixXd& J) {
  const ParameterLayout layout = ParameterLayout::of(id.fit.cell);
  NullSpace open = null_space(J / id.uncertainty.sigma0_mm, parameter_names(id.fit.cell),
                              conventional_preference(layout), usual_deviation(layout));
  id.result.unknown = std::move(open.unknown);
  id.result.weak = std::move(open.weak);
  const Eigen::MatrixXd kept = J(Eigen::all, id.identified);
  id.result.observability =
      observability(kept * column_norms(kept).cwiseInverse().asDiagonal(), count_poses(id.points.points()));
}

}  // namespace

std::optional<CalibrationError> fit_geometry(Identification& id, Weighing weighing) {
  if (auto error = judge_poses(id)) return error;
  Eigen::MatrixXd seen;
  if (determined(id)) {
    id.fit = weighing == Weighing::Anew ? fit_under_loss(id, id.result.coarse)
                                        : solve(id.result.coarse, id.problem, id.options.max_fine_iterations);
    id.result.fine_iterations = id.fit.iterations;
    id.result.fine_rms_mm = id.fit.rms_mm;
    seen = assess(id);
  }
  id.result.prior_used = prior_wanted(id);
  if (id.result.prior_used) seen = use_prior(id);
  if (id.identified.empty())
    return CalibrationError{CalibrationFault::TooFewPoses, "the loss leaves no point to identify from"};
  id.result.converged = id.result.converged && id.fit.converged;
  id.result.geometric = id.fit.cell;
  describe_known(id, seen);
  return std::nullopt;
}

}  // namespace truepose
