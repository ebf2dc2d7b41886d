#include "core/fit/point_fit.hpp"

#include <algorithm>
#include <cmath>

#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

/// The equations in units of their noise, one below the other.
struct WhitenedEquations {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;

  explicit WhitenedEquations(std::span<const PointEquation> equations)
      : A(3 * static_cast<Eigen::Index>(equations.size()), equations[0].A.cols()), b(A.rows()) {
    for (Eigen::Index row = 0; const PointEquation& equation : equations) {
      const Eigen::Matrix3d W = inverse_cholesky(equation.covariance);
      A.middleRows<3>(row) = W * equation.A;
      b.segment<3>(row) = W * equation.b;
      row += 3;
    }
  }
};

/// Of a reading: its square distance, in its own noise, from where the others say, and what it adds to the
/// square sum of all.
double of_others(const Eigen::Vector3d& f, const Eigen::Matrix3d& hat) {
  constexpr double kDecides = 1e-6;  // share of itself that the reading leaves to the others
  const Eigen::Matrix3d left = Eigen::Matrix3d::Identity() - hat;
  return left.determinant() > kDecides ? f.dot(left.inverse() * f) : 0;
}

}  // namespace

Eigen::VectorXd solve_points(std::span<const PointEquation> equations) {
  const WhitenedEquations system(equations);
  return CholeskyFactor(gram(system.A)).solve(transposed_times(system.A, system.b));
}

PointFit fit_points(std::span<const PointEquation> equations) {
  const WhitenedEquations system(equations);
  const CholeskyFactor normal(gram(system.A));
  PointFit fit{.u = normal.solve(transposed_times(system.A, system.b)), .covariance = normal.inverse()};
  const Eigen::VectorXd f = times(system.A, fit.u) - system.b;
  const double square_sum = f.squaredNorm();
  const auto spare = static_cast<double>(system.A.rows() - system.A.cols());
  if (spare > 0) fit.sigma0 = std::sqrt(square_sum / spare);
  for (Eigen::Index row = 0; const PointEquation& equation : equations) {
    const Eigen::Matrix3d hat = congruence(system.A.middleRows<3>(row), fit.covariance);
    const double alone = of_others(f.segment<3>(row), hat);
    const double others = spare > 3 ? (square_sum - alone) / (spare - 3) : 0;
    fit.error_mm.push_back((equation.A * fit.u - equation.b).norm());
    fit.sigmas.push_back(std::sqrt(alone / std::max(1.0, others)));
    row += 3;
  }
  const double sigma0 = std::max(1.0, fit.sigma0.value_or(1));
  fit.covariance *= sigma0 * sigma0;
  return fit;
}

}  // namespace truepose
