#include "core/calibration/gauss_newton.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/calibration/identifiability.hpp"
#include "core/calibration/line_search.hpp"
#include "core/calibration/measurement_model.hpp"
#include "core/calibration/parameters.hpp"

namespace truepose {
namespace {

/// Smallest dx with min |f + J dx|, columns scaled to unit norm. Minus, where the paper prints plus: f =
/// model - measured.
Eigen::VectorXd least_squares_step(const LinearSystem& system) {
  const Eigen::VectorXd norm = column_norms(system.J);
  Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::ColPivHouseholderQRPreconditioner> svd(
      system.J * norm.cwiseInverse().asDiagonal(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(kRankTolerance);
  return -norm.cwiseInverse().cwiseProduct(svd.solve(system.f));
}

Eigen::VectorXd scattered(const Eigen::VectorXd& step, const std::vector<int>& free, int size) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(size);
  for (std::size_t k = 0; k < free.size(); ++k) all[free[k]] = step[static_cast<Eigen::Index>(k)];
  return all;
}

}  // namespace

LinearSystem linearise(const CalibratedCell& cell, std::span<const Measurement> points,
                       const std::vector<int>& free, const Eigen::VectorXd& weights) {
  LinearSystem system;
  Eigen::MatrixXd J;
  residuals_with_jacobian(cell, points, system.f, J);
  system.J.resize(J.rows(), static_cast<Eigen::Index>(free.size()));
  for (std::size_t k = 0; k < free.size(); ++k) system.J.col(static_cast<Eigen::Index>(k)) = J.col(free[k]);
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    system.f.segment<3>(3 * i) *= weights[i];
    system.J.middleRows<3>(3 * i) *= weights[i];
  }
  return system;
}

GaussNewtonResult gauss_newton(const CalibratedCell& start, std::span<const Measurement> points,
                               const std::vector<int>& free, const Eigen::VectorXd& weights,
                               const GaussNewtonOptions& options) {
  const int size = ParameterLayout::of(start).size();
  GaussNewtonResult result{.cell = start};
  LinearSystem system = linearise(start, points, free, weights);
  while (result.iterations < options.max_iterations) {
    ++result.iterations;
    const Eigen::VectorXd step = least_squares_step(system);
    const Eigen::VectorXd direction = scattered(step, free, size);
    const double change = (system.J * step).norm() / std::sqrt(static_cast<double>(points.size()));
    // A decrease of less than 1e-14 of the objective is lost in its rounding, so a line search cannot judge
    // it; the full step is the better point.
    const double rms = system.f.norm() / std::sqrt(static_cast<double>(points.size()));
    if (change < std::max(options.tolerance_mm, 1e-7 * rms)) {
      result.cell = moved(result.cell, direction);
      result.converged = true;
      return result;
    }
    LinearSystem next;
    const auto line = [&](double length) {
      next = linearise(moved(result.cell, length * direction), points, free, weights);
      return LinePoint{0.5 * next.f.squaredNorm(), next.f.dot(next.J * step)};
    };
    const LinePoint here{0.5 * system.f.squaredNorm(), system.f.dot(system.J * step)};
    const auto length = strong_wolfe_step(line, here);
    if (!length) return result;
    result.cell = moved(result.cell, *length * direction);
    system = std::move(next);  // the search ends on the step that it returns
  }
  return result;
}

}  // namespace truepose
