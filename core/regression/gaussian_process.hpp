#pragma once

#include "core/regression/regressor.hpp"

namespace truepose {

/// Gaussian process of zero mean, one length scale per feature, correlation and noise ratio shared by the
/// targets. The hyper-parameters maximise the evidence, over a part of the points where they are many, from
/// a few fixed starts. Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006).
///
/// Hyper-parameters: `matern` (1, or 0 for squared exponential), `noise_ratio`, `length.0` to `length.<d-1>`.
std::map<std::string, double> gaussian_process_hyper(const RegressionData& data);
RegressorPtr make_gaussian_process(const RegressorState& state);

}  // namespace truepose
