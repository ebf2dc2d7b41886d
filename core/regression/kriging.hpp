#pragma once

#include "core/regression/regressor.hpp"

namespace truepose {

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
