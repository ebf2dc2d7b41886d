#include "core/fit/least_squares_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/data/calibrated_cell.hpp"
#include "core/fit/identifiability.hpp"
#include "core/fit/prepared_points.hpp"
#include "core/fit/whole_steps.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/line_search.hpp"

namespace truepose {
namespace {

/// Part of the RMS residual below which a change of the predicted points means nothing.
constexpr double kNegligible = 1e-5;

/// Whole steps. Does not allocate inside an iteration.
std::optional<FitResult> by_normal_equations(const CalibratedCell& start, const LeastSquaresProblem& problem,
                                             const GaussNewtonOptions& options,
                                             const kernels::Kernels& code) {
  if (!WholeSteps::possible(start, problem)) return std::nullopt;
  FitResult result{.cell = start, .solver = StepSolver::NormalEquations};
  result.rms_mm.reserve(static_cast<std::size_t>(options.max_iterations));
  PreparedPoints points(start.robot, problem.points, ParameterLayout::of(start).reflectors, problem.W, code);
  WholeSteps steps(start, points, problem);
  steps.evaluate(start);
  while (result.iterations < options.max_iterations) {
    ++result.iterations;
    const double rms = steps.rms_mm();
    const auto change = steps.advance(result.cell);
    if (!change) return std::nullopt;
    result.rms_mm.push_back(rms);
    if (ends_fit(*change, rms, options)) {
      result.converged = true;
      return result;
    }
    steps.evaluate(result.cell);
    if (!descends(rms, steps.rms_mm())) return std::nullopt;
  }
  return result;
}

FitResult by_orthogonal_factors(const CalibratedCell& start, const LeastSquaresProblem& problem,
                                const GaussNewtonOptions& options) {
  const int size = ParameterLayout::of(start).size();
  const double root_points = std::sqrt(static_cast<double>(problem.points.size()));
  FitResult result{.cell = start};
  LinearSystem system = linearise(start, problem);
  while (result.iterations < options.max_iterations) {
    ++result.iterations;
    const Eigen::VectorXd step = least_squares_step(system);
    if (!step.allFinite()) return result;
    const Eigen::VectorXd direction = scattered(step, problem.free, size);
    const double change = times(system.J, step).norm() / root_points;
    const double rms = system.f.norm() / root_points;
    result.rms_mm.push_back(rms);
    // A decrease of less than 1e-12 of the objective is lost in its rounding, so a line search cannot judge
    // it; the full step is the better point.
    if (ends_fit(change, rms, options)) {
      result.cell = moved(result.cell, direction);
      result.converged = true;
      return result;
    }
    LinearSystem next;
    const auto line = [&](double length) {
      next = linearise(moved(result.cell, length * direction), problem);
      return LinePoint{0.5 * next.f.squaredNorm(), times(next.J, step).col(0).dot(next.f)};
    };
    const LinePoint here{0.5 * system.f.squaredNorm(), times(system.J, step).col(0).dot(system.f)};
    const auto length = strong_wolfe_step(line, here);
    // Near the minimum a decrease may be lost in the rounding of positions metres away.
    if (!length && change > kNegligible * rms) return result;
    result.cell = moved(result.cell, length.value_or(1) * direction);
    if (!length) {
      result.converged = true;
      return result;
    }
    system = std::move(next);  // the search ends on the step that it returns
  }
  return result;
}

}  // namespace

Eigen::VectorXd least_squares_step(const LinearSystem& system) {
  const Eigen::VectorXd norm = column_norms(system.J);
  const Eigen::MatrixXd unit = system.J * norm.cwiseInverse().asDiagonal();
  return -norm.cwiseInverse().cwiseProduct(smallest_solution(unit, system.f, kRankTolerance));
}

bool ends_fit(double change_mm, double rms_mm, const GaussNewtonOptions& options) {
  return change_mm < std::max(options.tolerance_mm, 1e-6 * rms_mm);
}

std::optional<FitResult> gauss_newton_by(StepSolver solver, const CalibratedCell& start,
                                         const LeastSquaresProblem& problem,
                                         const GaussNewtonOptions& options, const kernels::Kernels& code) {
  if (solver == StepSolver::Orthogonal) return by_orthogonal_factors(start, problem, options);
  return by_normal_equations(start, problem, options, code);
}

FitResult gauss_newton(const CalibratedCell& start, const LeastSquaresProblem& problem,
                       const GaussNewtonOptions& options) {
  if (auto fit = by_normal_equations(start, problem, options, kernels::best())) return *std::move(fit);
  return by_orthogonal_factors(start, problem, options);
}

namespace {

constexpr double kFirstDamping = 1e-3;
constexpr double kLeastDamping = 1e-14;  // below rounding of the normal matrix at unit diagonal
constexpr double kMostDamping = 1e12;
constexpr int kDampedIterations = 4;  // for each whole one: they are smaller

}  // namespace

FitResult levenberg_marquardt(const CalibratedCell& start, const LeastSquaresProblem& problem,
                              const GaussNewtonOptions& options) {
  const int size = ParameterLayout::of(start).size();
  const double root_points = std::sqrt(static_cast<double>(problem.points.size()));
  FitResult result{.cell = start};
  LinearSystem system = linearise(start, problem);
  double damping = kFirstDamping, growth = 2;
  while (result.iterations < options.max_iterations && damping < kMostDamping) {
    ++result.iterations;
    const double cost = system.f.squaredNorm();
    result.rms_mm.push_back(std::sqrt(cost) / root_points);
    const Eigen::VectorXd inverse_norm = column_norms(system.J).cwiseInverse();
    const Eigen::MatrixXd J = system.J * inverse_norm.asDiagonal();
    const Eigen::VectorXd g = transposed_times(J, system.f);
    Eigen::MatrixXd normal = gram(J);
    normal.diagonal().array() += damping;
    const Eigen::VectorXd scaled_step = -solve_symmetric(normal, g);
    const Eigen::VectorXd direction = scattered(inverse_norm.cwiseProduct(scaled_step), problem.free, size);

    const CalibratedCell next_cell = moved(result.cell, direction);
    LinearSystem next = linearise(next_cell, problem);
    const double predicted = scaled_step.dot(damping * scaled_step - g);
    const double gain = (cost - next.f.squaredNorm()) / predicted;
    const double change = times(J, scaled_step).norm() / root_points;
    const bool small = change < std::max(options.tolerance_mm, 1e-6 * std::sqrt(cost) / root_points);
    if (gain > 0 || small) {
      result.cell = next_cell;
      system = std::move(next);
      // The gain of a step too small to be measured is noise, and must not steer.
      const double factor = small ? 1.0 / 3 : std::max(1.0 / 3, 1 - std::pow(2 * gain - 1, 3));
      damping = std::max(kLeastDamping, damping * factor);
      growth = 2;
      if (small && damping < 1e-6) {
        result.converged = true;
        return result;
      }
    } else {
      damping *= growth;
      growth *= 2;
    }
  }
  return result;
}

FitResult joined(FitResult first, FitResult then) {
  then.iterations += first.iterations;
  then.rms_mm.insert(then.rms_mm.begin(), first.rms_mm.begin(), first.rms_mm.end());
  return then;
}

FitResult solve(const CalibratedCell& start, const LeastSquaresProblem& problem, int max_iterations) {
  FitResult fit = gauss_newton(start, problem, {.max_iterations = max_iterations});
  if (fit.converged) return fit;
  // Poses that leave much open make long curved valleys, where whole steps must be cut to nearly nothing.
  FitResult damped =
      levenberg_marquardt(fit.cell, problem, {.max_iterations = kDampedIterations * max_iterations});
  return joined(std::move(fit), std::move(damped));
}

}  // namespace truepose
