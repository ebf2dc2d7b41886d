#pragma once

#include "core/field/regressor.hpp"

namespace truepose {

/// The mean of a few small networks (one hidden layer of tanh, linear outputs) begun from different seeds,
/// believed less with the distance from the data (PointCloud::belief). Trained by Levenberg-Marquardt; the
/// weight decay and the noise by the evidence, so no data are set aside to stop early.
/// Source: MacKay, A practical Bayesian framework for backpropagation networks (1992); Foresee and Hagan,
/// Gauss-Newton approximation to Bayesian learning (1997).
///
/// Hyper-parameters: `hidden`, `members`, `decay` and `noise` (precisions of weights and of targets at unit
/// scale). Weights of a member: hidden x (d + 1), then m x (hidden + 1), column by column, biases last.
RegressorState fit_neural_network(const RegressionData& data);
RegressorState refit_neural_network(const std::map<std::string, double>& hyper, const RegressionData& data);
RegressorPtr make_neural_network(const RegressorState& state);

/// How many weights a state must have.
std::size_t neural_network_weights(const RegressorState& state);

}  // namespace truepose
