#include "core/calibration/observability.hpp"

#include <cmath>

#include "core/linear_algebra/decompositions.hpp"

namespace truepose {

ObservabilityIndices observability(const Eigen::MatrixXd& scaled, int poses) {
  const Eigen::ArrayXd s = singular_values(triangular_factor(scaled));
  const double largest = s[0], smallest = s[s.size() - 1];
  return {.o1 = std::exp(s.log().mean()) / std::sqrt(static_cast<double>(poses)),
          .o2 = smallest / largest,
          .o3 = smallest,
          .o4 = smallest * smallest / largest,
          .o5 = 1 / s.inverse().sum()};
}

}  // namespace truepose
