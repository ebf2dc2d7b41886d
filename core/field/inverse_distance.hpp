#pragma once

#include "core/field/regressor.hpp"

namespace truepose {

/// Inverse distance weighting: the mean of the nearest points, weighted by distance^-power, believed less
/// with the distance from them (PointCloud::belief). Both hyper-parameters have the smallest leave-one-out
/// error of a grid. Source: Shepard, A two-dimensional interpolation function for irregularly-spaced data
/// (1968).
///
/// Hyper-parameters: `neighbours`, `power`.
std::map<std::string, double> inverse_distance_hyper(const RegressionData& data);
RegressorPtr make_inverse_distance(const RegressorState& state);

}  // namespace truepose
