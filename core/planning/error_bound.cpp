#include "core/planning/error_bound.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>

#include "core/linear_algebra/decompositions.hpp"
#include "core/linear_algebra/products.hpp"

namespace truepose {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kGap = 0.02;  // of the variance: between the bound and what the parts reach
constexpr int kMostSteps = 200;
// The power of its variance by which a position's weight grows: the first would take many more steps.
constexpr double kWeightPower = 3;

enum class Of { Mean, Worst };

/// Three rows a candidate.
MatrixXd all_rows(const DesignProblem& problem) {
  MatrixXd rows(3 * static_cast<Eigen::Index>(problem.candidates()), problem.parameters());
  for (std::size_t k = 0; k < problem.candidates(); ++k)
    rows.middleRows<3>(3 * static_cast<Eigen::Index>(k)) = problem.rows(k);
  return rows;
}

/// trace(R_k S R_k') of every three rows R_k.
VectorXd traces(const MatrixXd& rows, const MatrixXd& S) {
  const VectorXd of_rows = congruence_diagonal(rows, S);
  return of_rows.reshaped(3, of_rows.size() / 3).colwise().sum().transpose();
}

/// Sum of w_k R_k' R_k.
MatrixXd weighed(const MatrixXd& rows, const VectorXd& w) {
  const VectorXd of_rows = w.transpose().replicate(3, 1).reshaped();
  return transposed_times(rows, of_rows.asDiagonal() * rows);
}

double sum_of_greatest(VectorXd values, int count) {
  std::ranges::partial_sort(values, values.begin() + count, std::greater{});
  return values.head(count).sum();
}

/// Scaled until they sum to `total`; none is above one, since a candidate is measured once.
VectorXd capped(VectorXd parts, double total) {
  parts *= total / parts.sum();
  while (parts.maxCoeff() > 1) {
    const Eigen::Array<bool, Eigen::Dynamic, 1> whole = parts.array() >= 1;
    const double left = total - static_cast<double>(whole.count());
    const double rest = whole.select(VectorXd::Zero(parts.size()), parts).sum();
    parts = whole.select(VectorXd::Ones(parts.size()), parts * (rest > 0 ? left / rest : 0));
  }
  return parts;
}

/// Of the variance of the task's mean or worst position, mm^2.
double variance_bound(const DesignProblem& problem, const MatrixXd& rows, int poses, Of of) {
  const auto n = problem.parameters();
  const MatrixXd& task = problem.task_rows();
  VectorXd weights = VectorXd::Constant(task.rows() / 3, 3.0 / static_cast<double>(task.rows()));
  VectorXd parts = VectorXd::Constant(rows.rows() / 3, 3.0 * poses / static_cast<double>(rows.rows()));
  double bound = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    const MatrixXd M = MatrixXd::Identity(n, n) + weighed(rows, parts);
    const MatrixXd C = CholeskyFactor(M).inverse();
    const VectorXd variances = traces(task, C);
    const VectorXd slopes = traces(rows, congruence(C, weighed(task, weights)));
    bound = std::max(bound, weights.dot(variances) - sum_of_greatest(slopes, poses) + slopes.dot(parts));
    const double found = of == Of::Mean ? variances.mean() : variances.maxCoeff();
    if (bound >= (1 - kGap) * found) break;
    parts = capped(parts.cwiseProduct(slopes), poses);
    if (of == Of::Worst) {
      weights.array() *= (variances / variances.maxCoeff()).array().pow(kWeightPower);
      weights /= weights.sum();
    }
  }
  return bound;
}

}  // namespace

PredictedError error_bound(const DesignProblem& problem, int poses) {
  assert(poses > 0 && static_cast<std::size_t>(poses) <= problem.candidates());
  const MatrixXd rows = all_rows(problem);
  return {std::sqrt(variance_bound(problem, rows, poses, Of::Mean)),
          std::sqrt(variance_bound(problem, rows, poses, Of::Worst))};
}

}  // namespace truepose
