#include "core/calibration/gauss_newton.hpp"

#include <algorithm>
#include <cmath>

#include "core/calibration/identifiability.hpp"
#include "core/calibration/line_search.hpp"
#include "core/calibration/parameters.hpp"
#include "core/linear_algebra/decompositions.hpp"

namespace truepose {
namespace {

/// Part of the RMS residual below which a change of the predicted points means nothing.
constexpr double kNegligible = 1e-5;

/// Smallest dx with min |f + J dx|, columns scaled to unit norm. Minus, where the paper prints plus: f =
/// model - measured.
Eigen::VectorXd least_squares_step(const LinearSystem& system) {
  const Eigen::VectorXd norm = column_norms(system.J);
  const Eigen::MatrixXd unit = system.J * norm.cwiseInverse().asDiagonal();
  return -norm.cwiseInverse().cwiseProduct(smallest_solution(unit, system.f, kRankTolerance));
}

}  // namespace

FitResult gauss_newton(const CalibratedCell& start, const LeastSquaresProblem& problem,
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
    const double change = (system.J * step).norm() / root_points;
    const double rms = system.f.norm() / root_points;
    result.rms_mm.push_back(rms);
    // A decrease of less than 1e-12 of the objective is lost in its rounding, so a line search cannot judge
    // it; the full step is the better point.
    if (change < std::max(options.tolerance_mm, 1e-6 * rms)) {
      result.cell = moved(result.cell, direction);
      result.converged = true;
      return result;
    }
    if (!options.line_search) {
      result.cell = moved(result.cell, direction);
      system = linearise(result.cell, problem);
      continue;
    }
    LinearSystem next;
    const auto line = [&](double length) {
      next = linearise(moved(result.cell, length * direction), problem);
      return LinePoint{0.5 * next.f.squaredNorm(), next.f.dot(next.J * step)};
    };
    const LinePoint here{0.5 * system.f.squaredNorm(), system.f.dot(system.J * step)};
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

}  // namespace truepose
