#include "core/kernels/fast_gauss_newton.hpp"

#include <algorithm>
#include <cmath>

#include "core/calibration/parameters.hpp"
#include "core/kernels/normal_equations.hpp"

namespace truepose {
namespace {

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

}  // namespace

std::optional<FitResult> fast_gauss_newton(const CalibratedCell& start, const PreparedPoints& points,
                                           const std::vector<int>& free, const GaussNewtonOptions& options) {
  // The coordinates of a predicted point are not known better than this (mm).
  constexpr double kRounding_mm = 1e-10;
  FitResult result{.cell = start};
  result.rms_mm.reserve(static_cast<std::size_t>(options.max_iterations));
  NormalEquations equations(start, points, free);
  NormalStep step(static_cast<int>(free.size()));
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(ParameterLayout::of(start).size());

  equations.evaluate(start);
  while (result.iterations < options.max_iterations) {
    ++result.iterations;
    if (!step.solve(equations, points.code())) return std::nullopt;
    for (std::size_t k = 0; k < free.size(); ++k)
      direction[free[k]] = step.step()[static_cast<Eigen::Index>(k)];
    const double change = std::sqrt(step.promised(equations) / points.size());
    const double cost = equations.cost();
    const double rms = std::sqrt(cost / points.size());
    if (!std::isfinite(change)) return std::nullopt;
    result.rms_mm.push_back(rms);
    move_by(result.cell, direction);
    if (change < std::max(options.tolerance_mm, 1e-6 * rms)) {
      result.converged = true;
      return result;
    }
    equations.evaluate(result.cell);
    // Written so that a NaN fails.
    if (!(std::sqrt(equations.cost() / points.size()) <= rms + kRounding_mm)) return std::nullopt;
  }
  return result;
}

}  // namespace truepose
