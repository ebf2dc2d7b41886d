#include "core/fit/left_out_sides.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "core/math/dense_algebra.hpp"

namespace truepose {
namespace {

constexpr double kSide = 1.0 / 3;  // of the points

/// Mean square of the errors of some rows as the others predict them, over what these expect of it.
///
/// @param left_out  of each row, whether it is left out
std::optional<double> square_over_expected(const LinearSystem& system, const std::vector<bool>& left_out) {
  std::vector<int> out, in;
  for (int row = 0; row < static_cast<int>(system.f.size()); ++row)
    (left_out[static_cast<std::size_t>(row)] ? out : in).push_back(row);
  const Eigen::VectorXd scale = column_norms(system.J).cwiseInverse();
  const Eigen::MatrixXd J = system.J(in, Eigen::all) * scale.asDiagonal();
  const CholeskyFactor normal(gram(J));
  const auto degrees = static_cast<double>(J.rows() - J.cols());
  if (!normal.succeeded() || degrees < 1) return std::nullopt;
  const Eigen::VectorXd f = system.f(in);
  const Eigen::VectorXd step = normal.solve(transposed_times(J, f));
  const double variance = (f - times(J, step).col(0)).squaredNorm() / degrees;
  const Eigen::MatrixXd J_out = system.J(out, Eigen::all) * scale.asDiagonal();
  const double errors = (system.f(out) - times(J_out, step).col(0)).squaredNorm();
  const double spread = normal.solve_lower(J_out.transpose()).squaredNorm();
  const double expected = variance * (static_cast<double>(out.size()) + spread);
  return expected > 0 ? std::optional{errors / expected} : std::nullopt;
}

}  // namespace

double left_out_sides_factor(const LeastSquaresProblem& problem, const LinearSystem& system) {
  const std::span<const Measurement> points = problem.points;
  if (points.empty()) return 1;
  const auto rows = rows_of_points(problem);
  const auto side = static_cast<std::size_t>(kSide * static_cast<double>(points.size()));
  double sum = 0;
  int sides = 0;
  for (Eigen::Index joint = 0; joint < points.front().q.size(); ++joint) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return points[i].q[joint]; });
    for (const bool highest : {false, true}) {
      std::vector<bool> left_out(static_cast<std::size_t>(system.f.size()));
      for (std::size_t k = 0; k < side; ++k)
        for (const int row : rows[highest ? order[order.size() - 1 - k] : order[k]])
          left_out[static_cast<std::size_t>(row)] = true;
      if (const auto ratio = square_over_expected(system, left_out)) {
        sum += *ratio;
        ++sides;
      }
    }
  }
  return sides > 0 ? std::max(1.0, std::sqrt(sum / sides)) : 1;
}

}  // namespace truepose
