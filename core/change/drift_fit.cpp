#include "core/change/drift_fit.hpp"

#include <algorithm>
#include <cmath>

#include "core/fit/least_squares_problem.hpp"
#include "core/math/dense_algebra.hpp"

namespace truepose {

Eigen::MatrixXd covariance_of(const std::vector<ChangePrior>& priors, const ChangePrior* without,
                              Eigen::Index size) {
  Eigen::MatrixXd K = Eigen::MatrixXd::Identity(size, size);
  for (const ChangePrior& prior : priors) {
    if (&prior == without || prior.width == 0) continue;
    K += prior.width * prior.width * times_transposed(prior.columns, prior.columns);
  }
  return K;
}

namespace {

constexpr std::size_t kPointsPerWrong = 4;  // that are needed to call one of them wrong

/// Of one change among others that happened.
///
/// @param others  covariance of the whitened residuals without the change
ChangeEvidence evidence_beside(const ChangePrior& prior, const Eigen::MatrixXd& others,
                               const Eigen::VectorXd& b) {
  const CholeskyFactor factor(others);
  const Eigen::MatrixXd A = factor.solve_lower(prior.columns);
  return {gram(A), transposed_times(A, factor.solve_lower(b))};
}

bool is_wrong_reading(const ChangePrior& prior) { return prior.is(ChangeKind::Reading) && prior.width > 0; }

/// Takes the step that raises the evidence most: a change more, one less, or another width.
/// @return whether one paid
bool step_up(std::vector<ChangePrior>& priors, const Eigen::VectorXd& b) {
  constexpr double kLeast = 1e-3;
  const auto wrong = static_cast<std::size_t>(std::ranges::count_if(priors, is_wrong_reading));
  const bool may_be_wrong = wrong < static_cast<std::size_t>(b.size()) / 3 / kPointsPerWrong;
  ChangePrior* best = nullptr;
  double best_width = 0, best_gain = 0;
  for (ChangePrior& prior : priors) {
    if (prior.is(ChangeKind::Reading) && prior.width == 0 && !may_be_wrong) continue;
    const ChangeEvidence evidence = evidence_beside(prior, covariance_of(priors, &prior, b.size()), b);
    const double width = evidence.best_width(prior.least);
    const double gain = evidence.at(width) - evidence.at(prior.width);
    if (gain < (prior.width == 0 ? kPays : kLeast) || gain <= best_gain) continue;
    best = &prior;
    best_width = width;
    best_gain = gain;
  }
  if (best) best->width = best_width;
  return best;
}

void choose_widths(std::vector<ChangePrior>& priors, const Eigen::VectorXd& b) {
  constexpr int kMostSteps = 100;
  for (ChangePrior& prior : priors) prior.width = prior.least;
  for (int n = 0; n < kMostSteps && step_up(priors, b); ++n) continue;
}

ChangePosterior posterior_of(const std::vector<ChangePrior>& priors, const Eigen::VectorXd& b,
                             Eigen::Index parameters) {
  ChangePosterior posterior;
  posterior.B.resize(b.size(), 0);
  posterior.D.resize(parameters, 0);
  for (const ChangePrior& prior : priors) {
    if (prior.width == 0) continue;
    const Eigen::Index columns = posterior.B.cols() + prior.columns.cols();
    posterior.B.conservativeResize(Eigen::NoChange, columns);
    posterior.D.conservativeResize(Eigen::NoChange, columns);
    posterior.B.rightCols(prior.columns.cols()) = prior.width * prior.columns;
    posterior.D.rightCols(prior.columns.cols()) = prior.width * prior.directions;
  }
  Eigen::MatrixXd precision = gram(posterior.B);
  precision.diagonal().array() += 1;
  posterior.H = inverse(precision);
  posterior.z = times(posterior.H, transposed_times(posterior.B, b));
  posterior.left = b - times(posterior.B, posterior.z);
  return posterior;
}

void fill_columns(DriftFit& fit) {
  for (ChangePrior& prior : fit.priors) {
    prior.directions = directions_of(prior.changes, fit.cell);
    if (prior.is(ChangeKind::Reading))
      prior.columns = fit.residuals->inverse.middleCols<3>(3 * prior.changes.front().what.index);
    else
      prior.columns = times(fit.residuals->J, prior.directions);
  }
}

double evidence_of(const DriftFit& fit) {
  const Eigen::MatrixXd K = covariance_of(fit.priors, nullptr, fit.residuals->r.size());
  const double det =
      CholeskyFactor(K).log_determinant() - 2 * fit.residuals->inverse.diagonal().array().log().sum();
  return -0.5 * (fit.posterior.left.squaredNorm() + fit.posterior.z.squaredNorm() + det);
}

bool moves_parameters(ChangeKind kind) { return kind != ChangeKind::Reading && kind != ChangeKind::Growth; }

}  // namespace

std::expected<DriftFit, std::string> fitted_drift(const DriftReference& reference,
                                                  std::span<const Measurement> points, DriftFit start,
                                                  Widths widths) {
  constexpr int kMaxSteps = 30;
  constexpr double kSettled = 0.1, kDone = 1e-6;  // standard deviations
  DriftFit fit = std::move(start);
  fit.x = Eigen::VectorXd::Zero(ParameterLayout::of(fit.cell).size());
  double last = HUGE_VAL;
  for (int step = 0; step < kMaxSteps && last > kDone; ++step) {
    if (step > 0 || !fit.residuals) {
      auto residuals = drift_residuals(reference, fit.cell, points);
      if (!residuals) return std::unexpected(residuals.error());
      fit.residuals = std::make_shared<DriftResiduals>(*std::move(residuals));
    }
    fill_columns(fit);
    const Eigen::VectorXd b = fit.residuals->r + times(fit.residuals->J, fit.x);
    if (widths == Widths::Chosen && last > kSettled) choose_widths(fit.priors, b);
    fit.posterior = posterior_of(fit.priors, b, fit.x.size());
    if (widths == Widths::Chosen) fit.evidence = evidence_of(fit);
    const Eigen::VectorXd x = times(fit.posterior.D, fit.posterior.z);
    last = times(fit.residuals->J, x - fit.x).norm();
    move_by(fit.cell, x - fit.x);
    fit.x = x;
  }
  return fit;
}

std::vector<ChangeFound> found_in(const DriftFit& fit, const DriftReference& reference) {
  std::vector<ChangeFound> all;
  Eigen::Index unknown = 0;
  for (const ChangePrior& prior : fit.priors) {
    if (prior.width == 0) continue;
    for (const PossibleChange& change : prior.changes) {
      const Eigen::VectorXd units = prior.width * units_of(change, fit.cell);
      const auto of_change = Eigen::seqN(unknown, units.size());
      unknown += units.size();
      ChangeFound found{{change.what}};
      found.moved = moves_parameters(change.what.kind)
                        ? moved_between(reference.cell, fit.cell, change.what)
                        : Eigen::VectorXd(units.cwiseProduct(fit.posterior.z(of_change)));
      found.sigma = units.cwiseProduct(fit.posterior.H.diagonal()(of_change).cwiseSqrt());
      all.push_back(std::move(found));
    }
  }
  return all;
}

}  // namespace truepose
