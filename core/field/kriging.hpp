#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/field/regressor.hpp"

namespace truepose {

/// Half the expected squared difference of two targets, by the distance h of their poses:
/// gamma(h) = nugget + sill (1 - rho(h / range)) for h > 0. Targets at unit scale.
struct Semivariogram {
  enum class Model { Spherical, Exponential, Gaussian };

  Model model = Model::Spherical;
  double nugget = 0;  ///< variance of the noise
  double sill = 0;    ///< variance of the field
  double range = 1;   ///< in units of the features' spread

  /// rho(h / range): 1 at 0.
  double correlation(double distance) const;
};

/// Fits each model to the binned empirical semivariogram of all targets by weighted least squares, and keeps
/// the best. Pairs of one group are left out: they share what one group has in common.
///
/// @param Z  N x d features at unit spread
/// @param T  N x m targets at unit scale
/// @param groups  of each point
/// Source: Cressie, Fitting variogram models by weighted least squares (1985); range by search, as the model
/// is linear in the rest.
Semivariogram fit_semivariogram(const Eigen::MatrixXd& Z, const Eigen::MatrixXd& T,
                                const std::vector<int>& groups);

/// Ordinary kriging of error similarity: poses with similar joints have similar errors, and a semivariogram
/// says how similar by their distance. The nearest points predict, their nugget taken for noise, believed
/// less with the distance from them (PointCloud::belief). The number of neighbours has the smallest
/// leave-one-out error. Source: Tian, Zeng, Zhou, Liao, Calibration of robot positioning errors by error
/// similarity (2014); Cressie, Statistics for Spatial Data (1993), section 3.2.
///
/// Hyper-parameters: `model` (0 spherical, 1 exponential, 2 Gaussian), `nugget`, `sill`, `range`,
/// `neighbours`.
std::map<std::string, double> kriging_hyper(const RegressionData& data);
RegressorPtr make_kriging(const RegressorState& state);

}  // namespace truepose
