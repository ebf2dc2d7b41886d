#pragma once

#include <Eigen/Core>
#include <expected>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/change/change_hypothesis.hpp"
#include "core/change/drift_reference.hpp"

namespace truepose {

/// Changes whose unknowns have a prior of one width.
struct ChangePrior {
  std::vector<PossibleChange> changes;
  Eigen::MatrixXd directions;  ///< parameters per unit of each unknown; zero for a reading
  Eigen::MatrixXd columns;     ///< by which the units move the whitened residuals
  double least = 0;            ///< width: above 0, the change is known to have happened
  double width = 0;            ///< standard deviation in units; 0: it is taken not to have happened

  bool is(ChangeKind kind) const { return changes.front().what.kind == kind; }
};

/// Covariance of the whitened residuals: that of an unchanged cell is one.
/// @param without  left out; null: none
Eigen::MatrixXd covariance_of(const std::vector<ChangePrior>& priors, const ChangePrior* without,
                              Eigen::Index size);

/// What the residuals say of all changes that happened, in units of their priors.
struct ChangePosterior {
  Eigen::MatrixXd B;     ///< by which they move the whitened residuals
  Eigen::MatrixXd H;     ///< their covariance
  Eigen::VectorXd z;     ///< their mean
  Eigen::VectorXd left;  ///< whitened residuals that they leave
  Eigen::MatrixXd D;     ///< by which they move the parameters

  /// How many of them the points determined, rather than the priors.
  double determined() const { return static_cast<double>(H.rows()) - H.trace(); }
};

/// A cell on its way to the most probable one.
struct DriftFit {
  CalibratedCell cell;
  std::vector<ChangePrior> priors;
  std::shared_ptr<const DriftResiduals> residuals;  ///< of the cell; null: not yet known
  Eigen::VectorXd x;                                ///< by which its parameters moved from the start
  ChangePosterior posterior;
  double evidence = -HUGE_VAL;  ///< its logarithm, but for a constant; of chosen widths
};

enum class Widths { Kept, Chosen };

/// Gauss-Newton from `start`. Widths are chosen, until it settles, as those by which the residuals are most
/// probable, beginning with the least ones: one change after the other is taken in, let go or changed as long
/// as that pays. Of four points one may be wrong.
///
/// Errors: as drift_residuals().
/// Source: Tipping, Faul, Fast marginal likelihood maximisation for sparse Bayesian models, AISTATS 9 (2003).
std::expected<DriftFit, std::string> fitted_drift(const DriftReference& reference,
                                                  std::span<const Measurement> points, DriftFit start,
                                                  Widths widths);

/// The changes that happened, in the order of their priors.
std::vector<ChangeFound> found_in(const DriftFit& fit, const DriftReference& reference);

}  // namespace truepose
