#include "core/identify/identification.hpp"

#include <numeric>
#include <utility>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/least_squares_solver.hpp"
#include "core/identify/regression_field.hpp"
#include "core/identify/robust_fit.hpp"

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

namespace {

/// The prior of the deviation terms, beside that of the links where one is used.
void widen_prior(Identification& id, const ParameterLayout& layout) {
  Prior prior{Eigen::VectorXd::Zero(layout.size()), Eigen::VectorXd::Zero(layout.size())};
  if (id.problem.prior.weight.size() > 0) {
    const int links = layout.link(layout.joints);
    prior.centre.head(links) = id.problem.prior.centre.head(links);
    prior.weight.head(links) = id.problem.prior.weight.head(links);
  }
  prior.weight.tail(layout.deviations).setConstant(id.uncertainty.sigma0_mm / id.result.deviation->scale);
  id.problem.prior = std::move(prior);
}

}  // namespace

void fit_deviations(Identification& id) {
  const TrustedProblem trusted = trusted_problem(id);
  id.result.deviation = choose_deviation(id.fit.cell, trusted.problem,
                                         deviation_groups(id.nominal, trusted.points, id.options.harmonics));
  if (id.result.deviation->terms.empty()) return;

  CalibratedCell start = id.fit.cell;
  start.robot.deviation = id.result.deviation->terms;
  start.robot.torque_joints = id.nominal.joints;
  const ParameterLayout layout = ParameterLayout::of(start);
  for (int t = 0; t < layout.deviations; ++t) id.problem.free.push_back(layout.deviation(t));
  widen_prior(id, layout);
  id.fit = fit_under_loss(id, start);
  assess(id);
  widen_prior(id, layout);  // with the noise that is left once the deviations are in
  id.fit = solve(id.options, id.fit.cell, id.problem, id.options.max_fine_iterations);
  assess(id);
  id.result.converged = id.result.converged && id.fit.converged;
}

namespace {

/// The best of several kinds where it helps; a single one whether it helps or not.
std::expected<RegressorSelection, std::string> choose_regressor(const RegressionData& data,
                                                                const std::vector<RegressorKind>& kinds) {
  auto selection = select_regressor(data, kinds);
  if (!selection || selection->regressor || kinds.size() > 1) return selection;
  auto asked = fit_regressor(kinds.front(), data);
  if (!asked) return std::unexpected(asked.error());
  selection->kind = kinds.front();
  selection->regressor = std::move(*asked);
  return selection;
}

}  // namespace

std::optional<CalibrationError> fit_residual(Identification& id) {
  const FieldData data = field_data(id.fit.cell, id.points.trusted_points());
  auto selection = choose_regressor(data.regression, id.options.residual);
  if (!selection)
    return CalibrationError{CalibrationFault::TooFewPoses, "residual field: " + selection.error()};
  if (selection->regressor) {
    id.fit.cell.robot.field =
        std::make_shared<RegressionField>(id.fit.cell.robot, selection->regressor, data.p_F_mm);
  }
  id.result.residual = std::move(*selection);
  return std::nullopt;
}

}  // namespace truepose
