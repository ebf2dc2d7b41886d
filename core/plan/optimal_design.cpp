#include "core/plan/optimal_design.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "core/math/dense_algebra.hpp"
#include "core/math/random.hpp"
#include "core/step_count.hpp"

namespace truepose {
namespace {

// A gain below this part is rounding, and would let two equal poses change places for ever.
constexpr double kLeastExchangeGain = 1e-9;

/// The candidate not yet chosen with the greatest gain; `otherwise` where none gains more than that one.
std::size_t best_of(Design& design, std::size_t otherwise) {
  count_step();
  const std::span<const double> gains = design.gains();
  std::size_t best = otherwise;
  double best_gain = (1 + kLeastExchangeGain) * gains[otherwise];
  for (std::size_t k = 0; k < gains.size(); ++k) {
    if (gains[k] > best_gain && !design.has(k)) {
      best = k;
      best_gain = gains[k];
    }
  }
  return best;
}

void exchange(Design& design, int max_passes) {
  bool improved = true;
  for (int pass = 0; improved && pass < max_passes; ++pass) {
    improved = false;
    for (const std::size_t given_up : std::vector<std::size_t>{design.chosen()}) {
      design.remove(given_up);
      const std::size_t better = best_of(design, given_up);
      better == given_up ? design.take_back(given_up) : design.add(better);
      improved = improved || better != given_up;
    }
    design.refresh();
  }
}

void add_randomly(Design& design, std::size_t candidates, int poses, Random& random) {
  std::vector<std::size_t> order(candidates);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = 0; i < static_cast<std::size_t>(poses); ++i) {
    std::swap(order[i], order[i + random.next() % (candidates - i)]);
    design.add(order[i]);
  }
  design.refresh();
}

}  // namespace

std::optional<std::size_t> best_addition(Design& design, const std::vector<bool>& allowed) {
  count_step();
  const std::span<const double> gains = design.gains();
  std::optional<std::size_t> best;
  for (std::size_t k = 0; k < gains.size(); ++k) {
    if ((allowed.empty() || allowed[k]) && !design.has(k) && (!best || gains[k] > gains[*best])) best = k;
  }
  return best;
}

void add_greedily(Design& design, int poses) {
  for (auto left = poses - static_cast<int>(design.chosen().size()); left > 0; --left) {
    const auto best = best_addition(design);
    assert(best);
    design.add(*best);
  }
}

std::vector<std::size_t> optimal_design(const DesignProblem& problem, const DesignOptions& options) {
  assert(options.poses >= 0 && static_cast<std::size_t>(options.poses) <= problem.candidates());
  Random random{options.seed};
  std::vector<std::size_t> best;
  double best_cost = 0;
  for (int start = 0; start <= options.restarts; ++start) {
    Design design{problem, options.criterion};
    start == 0 ? add_greedily(design, options.poses)
               : add_randomly(design, problem.candidates(), options.poses, random);
    exchange(design, options.max_passes);
    if (start > 0 && design.cost() >= best_cost) continue;
    best = design.chosen();
    best_cost = design.cost();
  }
  std::ranges::sort(best);
  return best;
}

std::vector<DesignSize> design_sizes(const DesignProblem& problem, const DesignOptions& options,
                                     std::span<const int> sizes) {
  std::vector<DesignSize> designs;
  for (const int poses : sizes) {
    DesignOptions of_size = options;
    of_size.poses = poses;
    designs.push_back({poses, predicted_error(problem, optimal_design(problem, of_size))});
  }
  return designs;
}

std::optional<int> enough_poses(std::span<const DesignSize> sizes, double repeatability_mm, double gain) {
  for (const DesignSize& size : sizes) {
    const double model_mm2 = size.error.rms_mm * size.error.rms_mm;
    const double floor_mm2 = 3 * repeatability_mm * repeatability_mm;
    if (std::sqrt(model_mm2 / 2 + floor_mm2) >= (1 - gain) * std::sqrt(model_mm2 + floor_mm2))
      return size.poses;
  }
  return std::nullopt;
}

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
