#include "core/calibrate/identification.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/least_squares_solver.hpp"
#include "core/fit/measurement_model.hpp"
#include "core/fit/regression_field.hpp"
#include "core/fit/robust_fit.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr int kMaxReweightings = 20;
constexpr int kMaxRounds = 4;

FitResult reweighted_fit(Identification& id, const CalibratedCell& start) {
  LeastSquaresProblem unweighted = id.problem;
  unweighted.W = id.points.whitening();
  unweighted.turn_weight = id.points.turn_whitening();
  const RobustFit robust = robust_fit(start, unweighted);
  FitResult fit{.cell = robust.cell};
  for (int i = 0; i < kMaxReweightings; ++i) {
    const bool changed = id.points.weigh(fit.cell, id.options.loss, robust.sigma_mm);
    if (i > 0 && !changed) break;
    id.points.weigh(id.problem);
    fit = joined(fit, solve(fit.cell, id.problem, id.options.max_fine_iterations));
  }
  return fit;
}

}  // namespace

Identification::Identification(RobotModel arm, MeasurementData measured, CalibrateOptions wanted)
    : nominal{std::move(arm)},
      data{std::move(measured)},
      options{std::move(wanted)},
      points{points_of(data, PoseSet::Identify), options.noise} {}

FitResult fit_under_loss(Identification& id, const CalibratedCell& start) {
  if (reweighs(id.options.loss)) return reweighted_fit(id, start);
  return solve(start, id.problem, id.options.max_fine_iterations);
}

TrustedProblem trusted_problem(const Identification& id) {
  TrustedProblem trusted{.points = id.points.trusted_points(), .problem = id.problem};
  trusted.problem.points = trusted.points;
  trusted.problem.W = id.points.trusted_whitening();
  trusted.problem.turn_weight = id.points.trusted_turns();
  return trusted;
}

namespace {

/// All parameters, those first that are fitted.
std::vector<int> fitted_first(const std::vector<int>& fitted, int size) {
  std::vector<int> order = fitted;
  for (int k = 0; k < size; ++k)
    if (std::ranges::find(fitted, k) == fitted.end()) order.push_back(k);
  return order;
}

/// Rows of the points, those first that are trusted.
std::vector<int> trusted_first(const LeastSquaresProblem& problem, const std::vector<bool>& trusted) {
  std::vector<int> rows;
  const auto of_points = rows_of_points(problem);
  for (const bool wanted : {true, false}) {
    for (std::size_t i = 0; i < trusted.size(); ++i)
      if (trusted[i] == wanted) rows.insert(rows.end(), of_points[i].begin(), of_points[i].end());
  }
  return rows;
}

/// What the trusted points say of the fitted parameters, and the prior.
///
/// @param seen  of all points
/// @param f     residuals of the trusted points
/// @param R     what they say of all parameters, those that are fitted first
LinearSystem trusted_part(const Identification& id, const LinearSystem& seen, const Eigen::VectorXd& f,
                          const Eigen::MatrixXd& R) {
  const auto fitted = static_cast<Eigen::Index>(id.problem.free.size());
  // Of a triangular factor the columns in front have the block in front as their own.
  const bool triangular = f.size() > R.cols();
  LinearSystem part{f, R.topLeftCorner(triangular ? fitted : R.rows(), fitted), seen.mountings};
  append_prior(part, id.fit.cell, id.problem);
  return part;
}

}  // namespace

TransferUncertainty transfer_of(const CalibratedCell& cell, const Eigen::MatrixXd& covariance) {
  constexpr int kPoses = 200;
  return transfer_uncertainty(cell, covariance, poses_within_limits(cell.robot, kPoses, 0));
}

Eigen::MatrixXd assess(Identification& id) {
  const CalibratedCell& cell = id.fit.cell;
  const int size = ParameterLayout::of(cell).size();
  const std::vector<int> order = fitted_first(id.problem.free, size);
  const LeastSquaresProblem all_points = id.points.problem(order);
  LinearSystem seen = linearise(cell, all_points);
  const Eigen::Index trusted = id.points.rows(), others = seen.f.size() - trusted;
  if (others > 0) {
    const std::vector<int> rows = trusted_first(all_points, id.points.trusted());
    seen = {seen.f(rows), seen.J(rows, Eigen::all), seen.mountings};
  }
  Eigen::MatrixXd R = triangular_factor(seen.J.topRows(trusted));
  id.uncertainty = uncertainty_of(trusted_part(id, seen, seen.f.head(trusted), R), id.problem, size,
                                  static_cast<int>(trusted));
  if (others > 0) {
    Eigen::MatrixXd all(R.rows() + others, size);
    all << R, seen.J.bottomRows(others);
    R = triangular_factor(all);
  }
  Eigen::MatrixXd factor(R.rows(), R.cols());
  factor(Eigen::all, order) = R;
  return factor;
}

namespace {

void fit_chosen_deviations(Identification& id) {
  const TrustedProblem trusted = trusted_problem(id);
  const ScaleExpectation expected{.noise = expected_noise(id.points.stated_sigma_mm()),
                                  .links = id.options.prior_scale};
  id.result.non_geometric = choose_deviation(
      id.fit.cell, trusted.problem, deviation_groups(id.nominal, trusted.points, id.options.harmonics),
      expected, id.options.jobs);
  const DeviationChoice& choice = *id.result.non_geometric;
  if (choice.terms.empty()) return;

  CalibratedCell start = id.fit.cell;
  start.robot.deviation = choice.terms;
  start.robot.torque_joints = id.nominal.joints;
  const ParameterLayout layout = ParameterLayout::of(start);
  for (int t = 0; t < layout.deviations; ++t) id.problem.free.push_back(layout.deviation(t));
  id.problem.prior = prior_of(start, id.problem.prior, choice.likely);
  if (choice.likely.links) id.result.prior_scale = *choice.likely.links;
  id.fit = fit_under_loss(id, start);
  assess(id);
  id.result.converged = id.result.converged && id.fit.converged;
}

}  // namespace

std::optional<CalibrationError> fit_deviations(Identification& id) {
  for (int round = 0; id.options.non_geometric && round < kMaxRounds; ++round) {
    const std::vector<bool> chosen_from = id.points.trusted();
    fit_chosen_deviations(id);
    if (id.points.trusted() == chosen_from || round + 1 == kMaxRounds) break;
    if (auto error = fit_geometry(id, Weighing::Kept)) return error;
  }
  return std::nullopt;
}

namespace {

/// By how much the variance of a field is larger than its regressor says. The parameters have taken their
/// part of what it is fitted to. Where few poses determined its hyper-parameters, its variance may be too
/// small at poses that it did not see.
double variance_factor(const Identification& id, const CrossValidation& chosen) {
  const double left = std::max(1.0, id.points.equations() - id.uncertainty.determined);
  const double surer = chosen.expected_rms > 0 ? std::max(1.0, chosen.rms / chosen.expected_rms) : 1.0;
  return id.points.equations() / left * surer * surer;
}

/// How well the fit is known with its field, which takes degrees of freedom as parameters do.
void assess_field(Identification& id, const Regressor& regressor) {
  const CalibratedCell& cell = id.fit.cell;
  if (const auto freedom = regressor.freedom()) {
    const TrustedProblem trusted = trusted_problem(id);
    const Eigen::VectorXd left = residuals(cell, trusted.points);
    double squares = 0;
    for (std::size_t i = 0; i < trusted.points.size(); ++i) {
      const Eigen::Vector3d error = left.segment<3>(3 * static_cast<Eigen::Index>(i));
      squares +=
          trusted.problem.W.empty() ? error.squaredNorm() : (trusted.problem.W[i] * error).squaredNorm();
    }
    const double taken =
        id.uncertainty.determined + *freedom * static_cast<double>(regressor.state().Y.cols());
    const double coordinates = 3 * static_cast<double>(trusted.points.size());
    id.uncertainty.sigma0_mm = std::sqrt(squares / std::max(1.0, coordinates - taken));
  }
}

/// Errors of all trusted points as the field predicts them that did not see their pose: it has seen none of
/// those that it is not made of.
///
/// @param seen_mm  of the points that it is made of, by fits that did not see them
std::vector<Eigen::Vector3d> unseen_errors(const Identification& id, const std::vector<bool>& made_of,
                                           std::span<const Eigen::Vector3d> seen_mm) {
  const Eigen::VectorXd others = residuals(id.fit.cell, id.points.trusted_points());
  std::vector<Eigen::Vector3d> errors;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < made_of.size(); ++i)
    errors.push_back(made_of[i] ? seen_mm[seen++] : others.segment<3>(3 * static_cast<Eigen::Index>(i)));
  return errors;
}

}  // namespace

std::optional<CalibrationError> fit_field(Identification& id) {
  const std::vector<Measurement> trusted = id.points.trusted_points();
  const std::vector<bool> made_of = makes_field(trusted);
  std::vector<Measurement> points;
  for (std::size_t i = 0; i < trusted.size(); ++i)
    if (made_of[i]) points.push_back(trusted[i]);
  const FieldData data = field_data(id.fit.cell, points);
  auto choice = choose_field(data.regression, id.options.field, {.jobs = id.options.jobs});
  if (!choice) return CalibrationError{CalibrationFault::TooFewPoses, "residual field: " + choice.error()};
  if (choice->chosen) {
    const auto field = std::make_shared<RegressionField>(id.fit.cell.robot, choice->regressor, data.p_F_mm,
                                                         variance_factor(id, choice->tried));
    const auto seen_mm = errors_with(choice->tried.predicted, *field, id.fit.cell, points);
    id.fit.cell.robot.field = field;
    id.unseen_mm = unseen_errors(id, made_of, seen_mm);
    assess_field(id, *choice->regressor);
  }
  id.result.field = *std::move(choice);
  return std::nullopt;
}

}  // namespace truepose
