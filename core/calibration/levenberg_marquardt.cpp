#include "core/calibration/levenberg_marquardt.hpp"

#include <algorithm>
#include <cmath>

#include "core/calibration/identifiability.hpp"
#include "core/calibration/parameters.hpp"
#include "core/linear_algebra/decompositions.hpp"
#include "core/linear_algebra/products.hpp"

namespace truepose {
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
