#pragma once

#include <utility>
#include <vector>

namespace truepose::report {

/// A smooth curve through scattered points (x, y), sampled at `samples` places (at least two) from the
/// smallest to the greatest x: at each a straight line fitted with Gaussian weights, single points far off
/// disregarded.
///
/// @param bandwidth  standard deviation of the weights, in units of x; above 0
/// @return empty for fewer than five points or where all have the same x
/// Source: Cleveland, Robust locally weighted regression, JASA 74 (1979), with a Gaussian for its tricube.
std::vector<std::pair<double, double>> local_regression(const std::vector<std::pair<double, double>>& points,
                                                        double bandwidth, int samples);

}  // namespace truepose::report
