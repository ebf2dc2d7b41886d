#pragma once

#include <Eigen/Core>
#include <vector>

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

}  // namespace truepose
