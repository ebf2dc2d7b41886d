#pragma once

#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

namespace truepose {

/// Where an axis is that is given `given(t)` from t = 0 on, every `period_s`: integrated by the midpoint rule
/// in steps of 20 us, and so without the product's own solution.
inline std::vector<double> lagging_axis(const std::function<double(double)>& given, double dead_time_s,
                                        double time_constant_s, double period_s, int samples) {
  constexpr double kStep_s = 2e-5;
  const int steps = static_cast<int>(std::lround(period_s / kStep_s));
  std::vector<double> axis;
  double y = given(0);
  for (int i = 0, step = 0; i < samples; ++i) {
    axis.push_back(y);
    for (int k = 0; k < steps; ++k, ++step) {
      const double t = (step + 0.5) * kStep_s - dead_time_s, u = given(t > 0 ? t : 0);
      y = time_constant_s > 0 ? y + kStep_s / (time_constant_s + kStep_s / 2) * (u - y) : u;
    }
  }
  return axis;
}

}  // namespace truepose
