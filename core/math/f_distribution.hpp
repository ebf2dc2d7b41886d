#pragma once

namespace truepose {

/// Probability that the ratio of two mean squares of normal variables of one variance exceeds x: the F
/// distribution. Exact to about 1e-12 of itself.
///
/// @param above, below  degrees of freedom of the numerator and of the denominator, above 0
/// Source: Abramowitz, Stegun, Handbook of Mathematical Functions (1964), 26.6.2 and 26.5.8 (continued
/// fraction, by Lentz' recurrence).
double f_tail(double x, double above, double below);

}  // namespace truepose
