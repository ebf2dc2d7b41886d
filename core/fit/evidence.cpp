#include "core/fit/evidence.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "core/math/dense_algebra.hpp"
#include "core/math/lbfgs.hpp"

namespace truepose {
namespace {

Eigen::VectorXd widths_of(const EvidenceProblem& problem, const Eigen::VectorXd& log_widths) {
  Eigen::VectorXd widths = problem.unit;
  for (Eigen::Index i = 0; i < widths.size(); ++i)
    widths[i] *= std::exp(log_widths[1 + problem.class_of[static_cast<std::size_t>(i)]]);
  return widths;
}

/// What is expected of one width, and its slope added to `slope`.
double expectation(const WidthExpectation& expected, double log_width, double& slope) {
  const double off = (log_width - std::log(expected.usual)) / expected.log_deviation;
  slope += off / expected.log_deviation;
  return 0.5 * off * off;
}

}  // namespace

double negative_log_evidence(const EvidenceProblem& problem, const Eigen::VectorXd& log_widths,
                             Eigen::VectorXd& gradient) {
  gradient = Eigen::VectorXd::Zero(log_widths.size());
  const double variance = std::exp(2 * log_widths[0]);
  const Eigen::VectorXd width = widths_of(problem, log_widths);
  Eigen::MatrixXd K = width.asDiagonal() * problem.JtJ * width.asDiagonal();
  K /= variance;
  K.diagonal().array() += 1;
  if (!K.allFinite()) return std::numeric_limits<double>::infinity();
  const CholeskyFactor factor{K};
  if (!factor.succeeded()) return std::numeric_limits<double>::infinity();

  const Eigen::VectorXd right = -width.cwiseProduct(problem.Jtr) / variance;
  const Eigen::VectorXd in_widths = factor.solve(right);  // the estimate of each unknown over its width
  const Eigen::VectorXd open = factor.inverse_lower().colwise().squaredNorm();  // what the data leave of it
  // |r + J x|^2 at the estimate, by K in_widths = right.
  const double explained = in_widths.dot(right);
  const double left = problem.rr / variance - explained;
  const double misfit = left - in_widths.squaredNorm();

  double value = problem.equations * log_widths[0] + 0.5 * (factor.log_determinant() + left) +
                 expectation(problem.noise, log_widths[0], gradient[0]);
  gradient[0] += problem.equations - (1 - open.array()).sum() - misfit;
  for (Eigen::Index i = 0; i < width.size(); ++i)
    gradient[1 + problem.class_of[static_cast<std::size_t>(i)]] += 1 - open[i] - in_widths[i] * in_widths[i];
  for (std::size_t c = 0; c < problem.classes.size(); ++c) {
    const auto k = static_cast<Eigen::Index>(1 + c);
    value += expectation(problem.classes[c], log_widths[k], gradient[k]);
  }
  return value;
}

Evidence most_evident(const EvidenceProblem& problem) {
  constexpr std::array kFirstNoises{0.3, 3.0};  // of the usual: what little data say may have two maxima
  const auto objective = [&](const Eigen::VectorXd& at, Eigen::VectorXd& gradient) {
    return negative_log_evidence(problem, at, gradient);
  };
  Minimum best{{}, std::numeric_limits<double>::infinity()};
  for (const double first : kFirstNoises) {
    Eigen::VectorXd start(1 + static_cast<Eigen::Index>(problem.classes.size()));
    start[0] = std::log(first * problem.noise.usual);
    for (std::size_t c = 0; c < problem.classes.size(); ++c)
      start[static_cast<Eigen::Index>(1 + c)] = std::log(problem.classes[c].usual);
    Minimum found = minimise(objective, start);
    if (best.x.size() == 0 || found.value < best.value) best = std::move(found);
  }
  Evidence evidence{.noise = std::exp(best.x[0]), .width = {}};
  for (Eigen::Index k = 1; k < best.x.size(); ++k) evidence.width.push_back(std::exp(best.x[k]));
  return evidence;
}

}  // namespace truepose
