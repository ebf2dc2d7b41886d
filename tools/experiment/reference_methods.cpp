#include "tools/experiment/reference_methods.hpp"

#include <cmath>
#include <limits>

#include "core/fit/identifiability.hpp"
#include "core/fit/placement.hpp"
#include "core/fit/prior.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr int kCoarseIterations = 200, kFineIterations = 50;

/// The prior whose strength generalised cross-validation chooses in the problem linearised at `cell`.
///
/// Source: Golub, Heath, Wahba, Generalized cross-validation as a method for choosing a good ridge parameter,
/// 1979.
Prior ridge_prior(const CalibratedCell& cell, const LeastSquaresProblem& problem, const PriorScale& scale) {
  LeastSquaresProblem unshrunk = problem;
  unshrunk.prior = {};
  const LinearSystem system = linearise(cell, unshrunk);
  const Prior unit = prior_of(cell, scale, 1.0);
  Eigen::VectorXd weight(static_cast<Eigen::Index>(problem.free.size()));
  for (Eigen::Index k = 0; k < weight.size(); ++k) {
    weight[k] = unit.weight[problem.free[static_cast<std::size_t>(k)]];
  }
  const Eigen::MatrixXd normal = gram(system.J);
  const Eigen::VectorXd g = transposed_times(system.J, system.f);
  const auto equations = static_cast<double>(system.f.size() - system.mountings);

  double best_score = std::numeric_limits<double>::infinity(), best_sigma = 0;
  for (double sigma = 1e-3; sigma < 1e2; sigma *= std::sqrt(10.0)) {
    Eigen::MatrixXd shrunk = normal;
    shrunk.diagonal() += (sigma * weight).cwiseAbs2();
    const double determined = solve_symmetric(shrunk, normal).trace();
    const double square = (system.f - times(system.J, solve_symmetric(shrunk, g))).squaredNorm();
    const double freedom = 1 - determined / equations;
    const double score = square / (freedom * freedom);
    if (score >= best_score) continue;
    best_score = score;
    best_sigma = sigma;
  }
  return prior_of(cell, scale, best_sigma);
}

FitResult solved_by(ReferenceMethod method, const CalibratedCell& start, const LeastSquaresProblem& problem,
                    int max_iterations) {
  if (method == ReferenceMethod::LevenbergMarquardt)
    return levenberg_marquardt(start, problem, {.max_iterations = max_iterations});
  if (method == ReferenceMethod::GaussNewton)
    return gauss_newton_in_whole_steps(start, problem, max_iterations);
  return solve(start, problem, max_iterations);
}

}  // namespace

ReferenceFit fit_by(ReferenceMethod method, const CalibratedCell& start, const MeasurementData& data) {
  const ParameterLayout layout = ParameterLayout::of(start);
  const LeastSquaresProblem placed{.points = data.points,
                                   .free = first_parameters(layout.link(0)),
                                   .W = {},
                                   .prior = placement_prior(layout)};
  ReferenceFit fit{.coarse = solved_by(method, start, placed, kCoarseIterations), .fine = {}};
  LeastSquaresProblem whole{
      .points = data.points, .free = first_parameters(layout.size()), .W = {}, .prior = {}};
  if (method == ReferenceMethod::Ridge) whole.prior = ridge_prior(fit.coarse.cell, whole, PriorScale{});
  fit.fine = solved_by(method, fit.coarse.cell, whole, kFineIterations);
  return fit;
}

FitResult gauss_newton_in_whole_steps(const CalibratedCell& start, const LeastSquaresProblem& problem,
                                      int max_iterations) {
  const int size = ParameterLayout::of(start).size();
  const double root_points = std::sqrt(static_cast<double>(problem.points.size()));
  FitResult result{.cell = start};
  while (result.iterations < max_iterations && !result.converged) {
    ++result.iterations;
    const LinearSystem system = linearise(result.cell, problem);
    const Eigen::VectorXd step = least_squares_step(system);
    if (!step.allFinite()) break;
    const double rms_mm = system.f.norm() / root_points;
    result.rms_mm.push_back(rms_mm);
    result.cell = moved(result.cell, scattered(step, problem.free, size));
    result.converged = ends_fit(times(system.J, step).norm() / root_points, rms_mm);
  }
  return result;
}

}  // namespace truepose
