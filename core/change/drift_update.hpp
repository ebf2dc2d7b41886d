#pragma once

#include <Eigen/Core>
#include <expected>
#include <span>
#include <string>
#include <vector>

#include "core/change/change_hypothesis.hpp"
#include "core/change/drift_reference.hpp"

namespace truepose {

/// A model brought up to date.
struct DriftUpdate {
  CalibratedCell cell;
  Eigen::MatrixXd covariance;      ///< of its parameters, as Calibration::covariance
  std::vector<ChangeFound> moves;  ///< of the cell, the first found first
  std::vector<ChangeFound> wrong;  ///< readings that take no part
  double before_mm = 0;            ///< mean error of the points under the old model
  double after_mm = 0;             ///< and under the new one, without the wrong readings
  double left_out_mm = 0;          ///< the same, each point predicted from the others alone
  double probability = 0;          ///< that an unchanged cell gives as much as the new model leaves
  bool explains = false;  ///< moves and wrong readings leave chance, and enough points to check them by
  std::vector<std::string>
      doubts;  ///< why it is not to be used, one sentence each; empty: nothing speaks against it
};

/// Brings base, reflectors and joint zeros of a calibrated cell up to date by a handful of points, with what
/// the calibration knows of all parameters as the prior. All lengths may have grown by one share, as those of
/// an arm that is warmer; else links and deviations keep their values.
///
/// Each change has a width of its own, zero unless the evidence of the points (their probability with all
/// changes integrated out) grows by more than twenty times with it, so that nothing moves by chance; a wrong
/// reading is a change like others. All joints' zeros have one width together where that is more probable
/// than a few that moved by themselves: of an arm that warmed up none is known to be still. The update is
/// doubted where what it leaves is no chance, where the others contradict a point, where points predicted
/// without them are no better than before, and where one parameter of a link that changed explains them
/// better than an arm that grew.
///
/// @param points  at least one; reflectors by index of the cell's
/// Errors: as drift_check().
/// Sources: Tipping, Faul, Fast marginal likelihood maximisation for sparse Bayesian models, AISTATS 9
/// (2003); Kass, Raftery, Bayes factors, JASA 90 (1995).
std::expected<DriftUpdate, std::string> update_after_drift(const DriftReference& reference,
                                                           std::span<const Measurement> points);

}  // namespace truepose
