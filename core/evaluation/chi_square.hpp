#pragma once

namespace truepose {

/// Probability that a chi-square variable exceeds x: 1 where x <= 0. Exact to about 1e-13 of itself.
///
/// @param degrees  of freedom, at least 1
/// Source: Abramowitz, Stegun, Handbook of Mathematical Functions (1964), 26.4.4 (odd degrees) and 26.4.5
/// (even degrees): finite sums of positive terms.
double chi_square_tail(double x, int degrees);

}  // namespace truepose
