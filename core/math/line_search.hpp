#pragma once

#include <functional>
#include <optional>

namespace truepose {

/// Value and slope of the objective along a search direction.
struct LinePoint {
  double value = 0;
  double slope = 0;
};

struct LineSearchOptions {
  double c1 = 1e-4;  ///< Armijo: value(s) <= value(0) + c1 s slope(0)
  double c2 = 0.9;   ///< strong Wolfe: |slope(s)| <= c2 |slope(0)|
  int max_evaluations = 40;
};

/// A step that meets the Armijo and strong Wolfe conditions, tried from 1 on; nothing where none was found
/// (the direction does not descend, or the evaluations ran out). Source: paper's eqs 17 and 18 (their primes
/// are printed as inverses); Nocedal and Wright, Numerical Optimization, 2nd ed., algorithms 3.5 and 3.6.
std::optional<double> strong_wolfe_step(const std::function<LinePoint(double)>& line, const LinePoint& start,
                                        const LineSearchOptions& options = {});

}  // namespace truepose
