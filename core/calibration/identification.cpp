#include "core/calibration/identification.hpp"

#include <numeric>
#include <utility>

#include "core/calibration/levenberg_marquardt.hpp"
#include "core/calibration/parameters.hpp"
#include "core/calibration/robust_fit.hpp"

namespace truepose {
namespace {

constexpr int kTransferPoses = 200;
constexpr int kMaxReweightings = 20;

/// Appends a fit that started where the other ended.
FitResult joined(FitResult first, FitResult then) {
  then.iterations += first.iterations;
  then.rms_mm.insert(then.rms_mm.begin(), first.rms_mm.begin(), first.rms_mm.end());
  return then;
}

FitResult reweighted_fit(Identification& id, const CalibratedCell& start) {
  LeastSquaresProblem unweighted = id.problem;
  unweighted.W = id.points.whitening();
  const RobustFit robust = robust_fit(start, unweighted);
  FitResult fit{.cell = robust.cell};
  for (int i = 0; i < kMaxReweightings; ++i) {
    const bool changed = id.points.weigh(fit.cell, id.options.loss, robust.sigma_mm);
    if (i > 0 && !changed) break;
    id.problem.W = id.points.weighted_whitening();
    fit = joined(fit, solve(id.options, fit.cell, id.problem, id.options.max_fine_iterations));
  }
  return fit;
}

}  // namespace

Identification::Identification(const RobotModel& arm, const MeasurementData& measured,
                               const CalibrateOptions& wanted)
    : nominal{arm},
      data{measured},
      options{wanted},
      points{points_of(data, PoseSet::Identify), options.noise} {
  result.method = options.method;
}

FitResult solve(const CalibrateOptions& options, const CalibratedCell& start,
                const LeastSquaresProblem& problem, int max_iterations) {
  if (options.method == CalibrationMethod::LevenbergMarquardt)
    return levenberg_marquardt(start, problem, {.max_iterations = max_iterations});
  return gauss_newton(
      start, problem,
      {.max_iterations = max_iterations, .line_search = options.method != CalibrationMethod::GaussNewton});
}

FitResult fit_under_loss(Identification& id, const CalibratedCell& start) {
  if (id.options.loss != Loss::Squared) return reweighted_fit(id, start);
  return solve(id.options, start, id.problem, id.options.max_fine_iterations);
}

TrustedProblem trusted_problem(const Identification& id) {
  TrustedProblem trusted{.points = id.points.trusted_points(), .problem = id.problem};
  trusted.problem.points = trusted.points;
  trusted.problem.W = id.points.trusted_whitening();
  return trusted;
}

void assess(Identification& id) {
  const CalibratedCell& cell = id.fit.cell;
  const TrustedProblem trusted = trusted_problem(id);
  id.uncertainty = uncertainty_of(linearise(cell, trusted.problem), trusted.problem,
                                  ParameterLayout::of(cell).size(), id.points.equations());
  id.result.transfer = transfer_uncertainty(cell, id.uncertainty.covariance,
                                            poses_within_limits(id.nominal, kTransferPoses, 0));
}

std::vector<int> first_parameters(int count) {
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), 0);
  return indices;
}

}  // namespace truepose
