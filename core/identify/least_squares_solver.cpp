#include "core/identify/least_squares_solver.hpp"

#include <algorithm>
#include <cmath>

#include "core/identify/calibrated_cell.hpp"
#include "core/identify/identifiability.hpp"
#include "core/identify/normal_equations.hpp"
#include "core/math/dense_algebra.hpp"
#include "core/math/line_search.hpp"

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

/// Squared pivots at unit column norm below this mean columns so dependent (condition above about 1e5) that
/// the normal equations lose digits that the fit needs.
constexpr double kSmallestPivot = 1e-10;

/// The step of the free parameters, with room reused from one iteration to the next.
class NormalStep {
 public:
  explicit NormalStep(int size)
      : size_{size},
        stride_{(size + kernels::kMostLanes) / kernels::kMostLanes * kernels::kMostLanes},
        lines_(static_cast<std::size_t>(size * stride_ / kernels::kMostLanes + 1)),
        scale_(size),
        step_(size) {}

  /// Solves J'WJ step = -J'Wf; false where that would lose digits.
  bool solve(const NormalEquations& equations, const kernels::Kernels& code) {
    for (int i = 0; i < size_; ++i) scale_[i] = 1 / std::sqrt(equations.product(i, i));
    double* const A = lines_[0].value;
    for (int i = 0; i < size_; ++i) {
      double* const column = A + i * stride_;
      for (int j = i; j < size_; ++j) column[j] = equations.product(i, j) * scale_[i] * scale_[j];
      column[size_] = -equations.gradient(i) * scale_[i];
    }
    // Written so that a NaN, of a column of zeros, fails.
    if (!(code.solve_positive(A, stride_, size_, step_.data()) > kSmallestPivot)) return false;
    step_.array() *= scale_.array();
    return true;
  }

  const Eigen::VectorXd& step() const { return step_; }

  /// |J step|^2, the decrease that the step promises, mm^2.
  double promised(const NormalEquations& equations) const {
    double along = 0;
    for (int i = 0; i < size_; ++i) along -= equations.gradient(i) * step_[i];
    return along;
  }

 private:
  int size_, stride_;
  std::vector<kernels::Line> lines_;
  Eigen::VectorXd scale_, step_;
};

/// Full steps by Cholesky's factorisation at unit column norm. Does not allocate inside an iteration.
std::optional<FitResult> by_normal_equations(const CalibratedCell& start, const LeastSquaresProblem& problem,
                                             const GaussNewtonOptions& options,
                                             const kernels::Kernels& code) {
  // The coordinates of a predicted point are not known better than this (mm).
  constexpr double kCoordinateRounding_mm = 1e-10;
  const ParameterLayout layout = ParameterLayout::of(start);
  const auto of_links = [&](int parameter) { return parameter >= layout.link(0); };
  if (std::ranges::count_if(problem.free, of_links) > NormalEquations::kMostLinkParameters)
    return std::nullopt;
  FitResult result{.cell = start, .solver = StepSolver::NormalEquations};
  result.rms_mm.reserve(static_cast<std::size_t>(options.max_iterations));
  PreparedPoints points(start.robot, problem.points, layout.reflectors, problem.W, code);
  NormalEquations equations(start, points, problem.free, problem.prior);
  NormalStep step(static_cast<int>(problem.free.size()));
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(layout.size());

  equations.evaluate(start);
  while (result.iterations < options.max_iterations) {
    ++result.iterations;
    if (!step.solve(equations, code)) return std::nullopt;
    for (std::size_t k = 0; k < problem.free.size(); ++k)
      direction[problem.free[k]] = step.step()[static_cast<Eigen::Index>(k)];
    const double change = std::sqrt(step.promised(equations) / points.size());
    const double rms = std::sqrt(equations.cost() / points.size());
    if (!std::isfinite(change)) return std::nullopt;
    result.rms_mm.push_back(rms);
    move_by(result.cell, direction);
    if (change < std::max(options.tolerance_mm, 1e-6 * rms)) {
      result.converged = true;
      return result;
    }
    equations.evaluate(result.cell);
    // Written so that a NaN fails.
    if (!(std::sqrt(equations.cost() / points.size()) <= rms + kCoordinateRounding_mm)) return std::nullopt;
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

}  // namespace truepose
