#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/calibration/parameters.hpp"

namespace truepose {

/// A direction counts as known when its pivot is above this part of the largest, with columns scaled to unit
/// norm.
inline constexpr double kRankTolerance = 1e-9;

/// What the data can tell of the columns of a Jacobian.
struct Identifiability {
  int rank = 0;
  double gap = 0;         ///< smallest pivot kept over the largest dropped; infinite where none was dropped
  std::vector<int> kept;  ///< as many independent columns as the rank, in ascending order
};

/// Norms of the columns, 1 for a column of zeros.
Eigen::VectorXd column_norms(const Eigen::MatrixXd& J);

/// Rank by column-pivoted QR at unit norm, and the columns that represent it.
///
/// @param preference  of each column, > 0: among columns that say the same, the more preferred is kept
/// Source: method's paper, eq. 20 with its permutation: J P = Q [R; 0].
Identifiability identifiability(const Eigen::MatrixXd& J, const Eigen::VectorXd& preference);

/// Condition of some columns at unit norm; 0 of none.
double condition_of(const Eigen::MatrixXd& J, const std::vector<int>& columns);

/// The project's convention on which parameters speak for a redundant group: base and reflectors before
/// links, the four of Denavit and Hartenberg before beta, theta before d. Predictions do not depend on it;
/// the printed values do.
Eigen::VectorXd conventional_preference(const ParameterLayout& layout);

}  // namespace truepose
