#include "core/change/drift_evidence.hpp"

#include <algorithm>
#include <cmath>

#include "core/math/dense_algebra.hpp"

namespace truepose {

namespace {

/// Of the base's, the reflectors' and the links' parameters.
bool is_angle(const ParameterLayout& layout, int parameter) {
  if (parameter < layout.reflector(0)) return parameter % ParameterLayout::kBase >= 3;
  if (parameter < layout.link(0)) return false;
  const int entry = (parameter - layout.link(0)) % ParameterLayout::kLink;
  return entry != ParameterLayout::kA && entry != ParameterLayout::kD;
}

Eigen::MatrixXd directions_of(const PossibleChange& change, const CalibratedCell& cell) {
  constexpr double kThousandth = 1e-3;
  const ParameterLayout layout = ParameterLayout::of(cell);
  if (change.what.kind == ChangeKind::Reading) return Eigen::MatrixXd::Zero(layout.size(), 3);
  if (change.what.kind == ChangeKind::Growth) {
    Eigen::MatrixXd lengths = Eigen::MatrixXd::Zero(layout.size(), 1);
    lengths(change.free, 0) = kThousandth * parameter_values(cell)(change.free);
    return lengths;
  }
  Eigen::MatrixXd directions =
      Eigen::MatrixXd::Zero(layout.size(), static_cast<Eigen::Index>(change.free.size()));
  for (Eigen::Index k = 0; k < directions.cols(); ++k) {
    const int parameter = change.free[static_cast<std::size_t>(k)];
    directions(parameter, k) = is_angle(layout, parameter) ? kThousandth : 1;
  }
  return directions;
}

}  // namespace

Eigen::MatrixXd directions_of(std::span<const PossibleChange> changes, const CalibratedCell& cell) {
  Eigen::MatrixXd all(ParameterLayout::of(cell).size(), 0);
  for (const PossibleChange& change : changes) {
    const Eigen::MatrixXd directions = directions_of(change, cell);
    all.conservativeResize(Eigen::NoChange, all.cols() + directions.cols());
    all.rightCols(directions.cols()) = directions;
  }
  return all;
}

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

/// How the evidence grows with the width of one change, the others kept.
class ChangeEvidence {
 public:
  /// @param others  covariance of the whitened residuals without the change
  ChangeEvidence(const ChangePrior& prior, const Eigen::MatrixXd& others, const Eigen::VectorXd& b) {
    const CholeskyFactor factor(others);
    const Svd svd = thin_svd(factor.solve_lower(prior.columns));
    s2_ = svd.s.cwiseAbs2();
    c2_ = transposed_times(svd.U, factor.solve_lower(b)).cwiseAbs2();
  }

  /// Logarithm of the evidence over that without the change.
  double at(double width) const {
    const Eigen::ArrayXd w = width * width * s2_.array();
    return 0.5 * (w / (1 + w) * c2_.array() - w.log1p()).sum();
  }

  double best_width(double least) const {
    double best = least;
    for (int k = -12; k <= 16; ++k) {
      const double width = std::pow(10, k / 4.0);
      if (width > least && at(width) > at(best)) best = width;
    }
    return best;
  }

 private:
  Eigen::VectorXd s2_, c2_;
};

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
    const ChangeEvidence evidence(prior, covariance_of(priors, &prior, b.size()), b);
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

}  // namespace

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

}  // namespace truepose
