#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/data/calibrated_cell.hpp"

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

/// Rank and gap by the pivots of a column-pivoted QR of columns at unit norm; nothing is kept.
Identifiability rank_by(const Eigen::VectorXd& pivots);

/// Norms of the columns, 1 for a column of zeros.
Eigen::VectorXd column_norms(const Eigen::MatrixXd& J);

/// Rank by column-pivoted QR at unit norm, and the columns that represent it.
///
/// @param preference  of each column, > 0: among columns that say the same, the more preferred is kept
/// Source: method's paper, eq. 20 with its permutation: J P = Q [R; 0].
Identifiability identifiability(const Eigen::MatrixXd& J, const Eigen::VectorXd& preference);

/// The project's convention on which parameters speak for a redundant group: base and reflectors before
/// links, the four of Denavit and Hartenberg before beta, theta before d. Predictions do not depend on it;
/// the printed values do.
Eigen::VectorXd conventional_preference(const ParameterLayout& layout);

/// How well a set of poses shows the parameters, one number each; larger is better.
/// Source: Sun and Hollerbach, Observability index selection for robot calibration, ICRA 2008; O2 to O4 are
/// Driels and Pathre's, Nahvi's, and Nahvi and Hollerbach's, O1 Borm and Menq's.
struct ObservabilityIndices {
  double o1 = 0;  ///< (s_1 ... s_m)^(1/m) / sqrt(N): D-optimality
  double o2 = 0;  ///< s_min / s_max
  double o3 = 0;  ///< s_min: E-optimality
  double o4 = 0;  ///< s_min^2 / s_max: the noise amplification index
  double o5 = 0;  ///< 1 / (1/s_1 + ... + 1/s_m): in the manner of A-optimality

  double condition() const { return 1 / o2; }
};

/// @param scaled  independent columns of a Jacobian, scaled so that they compare: to unit norm for one set of
///                poses (condition() is then what is commonly printed), by the usual deviation of
///                each parameter to compare sets
/// @param poses   N
ObservabilityIndices observability(const Eigen::MatrixXd& scaled, int poses);

}  // namespace truepose
