#pragma once

#include <Eigen/Core>

namespace truepose {

/// How well a set of poses shows the parameters, one number each; larger is better.
/// Source: Sun and Hollerbach, Observability index selection for robot calibration, ICRA 2008; O2 to O4 are
/// Driels and Pathre's, Nahvi's, and Nahvi and Hollerbach's, O1 Borm and Menq's.
struct ObservabilityIndices {
  double o1 = 0;  ///< (s_1 ... s_m)^(1/m) / sqrt(N): D-optimality
  double o2 = 0;  ///< s_min / s_max: the inverse condition
  double o3 = 0;  ///< s_min: E-optimality
  double o4 = 0;  ///< s_min^2 / s_max: the noise amplification index
  double o5 = 0;  ///< 1 / (1/s_1 + ... + 1/s_m): in the manner of A-optimality
};

/// @param scaled  independent columns of a Jacobian, scaled so that they compare: to unit norm for one set of
///                poses (O2 is then the inverse of Identifiability::condition), by the usual deviation of
///                each parameter to compare sets
/// @param poses   N
ObservabilityIndices observability(const Eigen::MatrixXd& scaled, int poses);

}  // namespace truepose
