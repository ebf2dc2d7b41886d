#pragma once

#include <Eigen/Core>
#include <functional>

namespace truepose {

/// Value at x, and the gradient there. A value that is not finite marks a point as out of bounds.
using Objective = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)>;

struct LbfgsOptions {
  int max_iterations = 60;
  double tolerance = 1e-4;  ///< done where a step lowers the value by less (in the objective's unit)
};

struct Minimum {
  Eigen::VectorXd x;
  double value = 0;
};

/// A local minimum by limited-memory BFGS with a strong Wolfe line search, never above the start.
/// Source: Nocedal and Wright, Numerical Optimization, 2nd ed., algorithms 7.4 and 7.5.
Minimum minimise(const Objective& objective, const Eigen::VectorXd& start, const LbfgsOptions& options = {});

}  // namespace truepose
