#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "core/change/cell_change.hpp"
#include "core/data/calibrated_cell.hpp"

namespace truepose {

/// A change is taken to have happened where that makes the points so many times as probable (as a logarithm),
/// all that it may have been integrated out.
///
/// Source: Kass, Raftery, Bayes factors, JASA 90 (1995): strong evidence.
inline const double kPays = std::log(20.0);

/// Changes whose unknowns have a prior of one width.
struct ChangePrior {
  std::vector<PossibleChange> changes;
  Eigen::MatrixXd directions;  ///< parameters per unit of each unknown; zero for a reading
  Eigen::MatrixXd columns;     ///< by which the units move the whitened residuals
  double least = 0;            ///< width: above 0, the change is known to have happened
  double width = 0;            ///< standard deviation in units; 0: it is taken not to have happened

  bool is(ChangeKind kind) const { return changes.front().what.kind == kind; }
};

/// How the changes' unknowns move the parameters: a column each for a mm, a mrad or a thousandth of all
/// lengths, which one metre away are much the same.
Eigen::MatrixXd directions_of(std::span<const PossibleChange> changes, const CalibratedCell& cell);

/// Chooses the widths by which the whitened residuals b are most probable, beginning with the least ones: one
/// change after the other is taken in, let go or changed as long as that pays. Of four points one may be
/// wrong.
///
/// Source: Tipping, Faul, Fast marginal likelihood maximisation for sparse Bayesian models, AISTATS 9 (2003).
void choose_widths(std::vector<ChangePrior>& priors, const Eigen::VectorXd& b);

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
/// @param parameters  of the cell
ChangePosterior posterior_of(const std::vector<ChangePrior>& priors, const Eigen::VectorXd& b,
                             Eigen::Index parameters);

}  // namespace truepose
